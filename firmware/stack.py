#!/usr/bin/env python3
"""The deepest stack of an image, by its code: frames along the deepest path of calls, and of each interrupt.

    firmware/stack.py IMAGE [FUNCTION...]

Needs arm-none-eabi-objdump. With names of functions, only paths from functions whose names contain one of them.
Calls through a pointer are counted and not followed; recursion, of which there should be none, is told.
"""

import re
import subprocess
import sys

CALL = re.compile(r"\t(?:bl|b|b\.w|b\.n)\s+[0-9a-f]+ <([^>+]+)>$")
REGISTERS = re.compile(r"\{(.*)\}")


def words(line):
    """Words in the list of registers of a push."""
    count = 0
    for part in REGISTERS.search(line)[1].split(","):
        low, _, high = part.strip().partition("-")
        count += int(high[1:]) - int(low[1:]) + 1 if high else 1
    return count


def functions(image):
    text = subprocess.run(["arm-none-eabi-objdump", "-d", "-C", image], capture_output=True, text=True, check=True).stdout
    name, found = None, {}
    for line in text.splitlines():
        begin = re.match(r"[0-9a-f]+ <(.+)>:$", line)
        if begin:
            name = begin[1]
            found[name] = {"frame": 0, "calls": set(), "pointers": 0}
            continue
        if name is None or "\t" not in line:
            continue
        function = found[name]
        code = "\t" + "\t".join(line.split("\t")[2:]).split(";")[0].rstrip()
        if re.match(r"\t(push|stmdb\s+sp!|stmdb\tsp!)", code):
            function["frame"] += 4 * words(code)
        elif code.startswith("\tvpush"):
            size = 8 if "d" in REGISTERS.search(code)[1] else 4
            function["frame"] += size * words(code)
        elif shift := re.match(r"\tsub(?:w|\.w)?\s+sp(?:, sp)?, #(\d+)", code):
            function["frame"] += int(shift[1])
        elif call := CALL.search(line.split(";")[0].rstrip()):
            if call[1] != name:
                function["calls"].add(call[1])
        elif code.startswith("\tblx\tr"):
            function["pointers"] += 1
    return found


def deepest(found, name, above=()):
    """Bytes and the path."""
    if name in above:
        return 0, [f"recursion to {name}"]
    if (function := found.get(name)) is None:
        return 0, []
    if "deepest" not in function:
        below = [deepest(found, call, (*above, name)) for call in function["calls"]]
        depth, path = max(below, default=(0, []), key=lambda pair: pair[0])
        function["deepest"] = function["frame"] + depth, [(function["frame"], name, function["pointers"]), *path]
    return function["deepest"]


def main():
    found = functions(sys.argv[1])
    roots = sys.argv[2:] or ["main", "SysTick", "TIM7", "USART2"]
    for root in roots:
        for name in [name for name in found if name == root] or [name for name in found if root in name]:
            depth, path = deepest(found, name)
            print(f"{depth} B from {name}")
            for step in path:
                if isinstance(step, tuple):
                    frame, function, pointers = step
                    print(f"  {frame:6} {function[:140]}{f', {pointers} calls by pointer' if pointers else ''}")
                else:
                    print(f"         {step}")


if __name__ == "__main__":
    main()
