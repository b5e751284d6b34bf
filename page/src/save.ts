// Files that the browser keeps.

/** Offers a file for download. */
export function save(content: BlobPart, type: string, name: string): void {
  const address = URL.createObjectURL(new Blob([content], { type }));
  download(address, name);
  setTimeout(() => URL.revokeObjectURL(address), 10_000);
}

/** Downloads what is at an address. */
export function download(address: string, name: string): void {
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
}
