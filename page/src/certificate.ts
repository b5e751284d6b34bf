// The certificate of a device: what `device selftest --json` printed.

import type { Answer, Values } from "./protocol";

interface Check {
  check: string;
  promised: string;
  seen: string;
  ok: boolean | null;
  not_judged: boolean;
}

interface Certificate extends Values {
  date: string;
  board: string;
  firmware: string;
  firmware_digest?: string;
  holds: boolean;
  checks: Check[];
}

/** As an answer, to be shown as one; null if the text is something else. */
export function certificate(name: string, text: string): Answer | null {
  const report = parsed(text);
  if (!isCertificate(report)) return null;
  const { date, board, firmware, firmware_digest: digest, holds, checks } = report;
  const columns = ["promise", "kept", "promised", "seen"];
  const rows = checks.map(({ check, promised, seen, ok, not_judged: open }) => [check, ok === null ? (open ? "not judged" : "–") : ok ? "yes" : "no", promised, seen]);
  const line = (label: string, value: string): Answer["lines"][number] => ({ level: 0, key: label, label, value, reason: "" });
  return {
    name,
    kind: "selftest",
    verdict: `${board}: ${holds ? "every promise was kept" : "not every promise was judged and kept"}`,
    report,
    lines: [line("date", date), line("firmware", firmware), ...(digest === undefined ? [] : [line("firmware digest", digest)]), { level: 0, key: "checks", label: "Promises", columns, rows, length: rows.length }],
    experiment: null,
  };
}

function parsed(text: string): unknown {
  try {
    return JSON.parse(text);
  } catch {
    return null;
  }
}

function isCertificate(value: unknown): value is Certificate {
  if (typeof value !== "object" || value === null) return false;
  const { checks, holds, ...texts } = value as Values;
  const words = (of: unknown, keys: string[]) => keys.every((key) => typeof (of as Values | null)?.[key] === "string");
  return typeof holds === "boolean" && words(texts, ["date", "board", "firmware"]) && Array.isArray(checks) && checks.every((check) => words(check, ["check", "promised", "seen"]));
}
