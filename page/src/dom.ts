// Elements, made and found.

type Attributes = Record<string, string | number | boolean | undefined>;
type Child = Node | string;

function fill<T extends Element>(element: T, attributes: Attributes, children: Child[]): T {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === false) continue;
    element.setAttribute(name, value === true ? "" : String(value));
  }
  element.append(...children);
  return element;
}

/** An element of HTML with attributes and children. */
export function el<K extends keyof HTMLElementTagNameMap>(
  name: K,
  attributes: Attributes = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  return fill(document.createElement(name), attributes, children);
}

/** An element of SVG. */
export function svg<K extends keyof SVGElementTagNameMap>(
  name: K,
  attributes: Attributes = {},
  ...children: Child[]
): SVGElementTagNameMap[K] {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", name), attributes, children);
}

/** A button, and what it does. */
export function button(text: Child, act: () => void, attributes: Attributes = {}): HTMLButtonElement {
  const made = el("button", { type: "button", ...attributes }, text);
  made.addEventListener("click", act);
  return made;
}

/** A list of values to choose from, by their texts. */
export function select(label: string, choices: readonly (readonly [value: string, text: string])[]): HTMLSelectElement {
  return el("select", { "aria-label": label }, ...choices.map(([value, text]) => el("option", { value }, text)));
}

/** What an error says. */
export function words(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

/** Sets attributes of an element that is there. */
export function set(element: Element, attributes: Record<string, string | number>): void {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
}

/** Text of an element; nothing is touched if it is the same. */
export function say(element: Element, text: string): void {
  if (element.textContent !== text) element.textContent = text;
}

/** Chooses a value in a list, which is added where it is not known, by this name. */
export function chosen(list: HTMLSelectElement, value: string, name = value): void {
  if (![...list.options].some((option) => option.value === value)) list.append(el("option", { value }, name));
  list.value = value;
}

/** A colour or length of the style sheet. */
export function style(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** True for what takes text: there the keys are no commands. */
export function isTextField(target: EventTarget | null): target is HTMLInputElement | HTMLTextAreaElement {
  return target instanceof HTMLElement && target.matches("input:not([type=range], [type=checkbox], [type=file]), textarea");
}

/** Calls back with the size of an element, now and whenever it changes, until what is given back is called. */
export function onSize(element: Element, changed: (width: number, height: number) => void): () => void {
  const observer = new ResizeObserver(() => changed(element.clientWidth, element.clientHeight));
  observer.observe(element);
  return () => observer.disconnect();
}
