#!/usr/bin/env python3
"""The deepest stack of an image, by its code: frames along the deepest path of calls, of the program and of interrupts.

    firmware/stack.py IMAGE [--most BYTES] [FUNCTION...]

Needs arm-none-eabi-objdump. Adds up the program, the tick and the line's interrupt, each with the 104 B that the processor
saves; exit code 1 if that is more than BYTES. With names of functions, only their paths. Calls through a pointer are
counted and not followed; recursion, of which there should be none, is told.
"""

import argparse
import re
import subprocess
import sys

CALL = re.compile(r"\t(?:bl|b[a-z]{0,2}(?:\.[nw])?)\s+([0-9a-f]+) <")
# Registers that the processor saves at an exception, with those of the floating point.
EXCEPTION = 104
REGISTERS = re.compile(r"\{(.*)\}")


def words(line):
    """Words in the list of registers of a push."""
    count = 0
    for part in REGISTERS.search(line)[1].split(","):
        low, _, high = part.strip().partition("-")
        count += int(high[1:]) - int(low[1:]) + 1 if high else 1
    return count


def lines(image, *options):
    command = ["arm-none-eabi-objdump", "-d", *options, image]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()


def functions(image):
    """By address: name, frame, calls."""
    found = {}
    for line in lines(image, "-C"):
        if begin := re.match(r"([0-9a-f]+) <(.+)>:$", line):
            found[int(begin[1], 16)] = {"name": begin[2], "frame": 0, "calls": set(), "pointers": 0}
    address = None
    for line in lines(image):
        if begin := re.match(r"([0-9a-f]+) <.+>:$", line):
            address = int(begin[1], 16)
            continue
        if address is None or "\t" not in line:
            continue
        function = found[address]
        code = "\t" + "\t".join(line.split("\t")[2:]).split(";")[0].rstrip()
        if re.match(r"\t(push|stmdb\s+sp!)", code):
            function["frame"] += 4 * words(code)
        elif code.startswith("\tvpush"):
            function["frame"] += (8 if "d" in REGISTERS.search(code)[1] else 4) * words(code)
        elif shift := re.match(r"\tsub(?:w|\.w)?\s+sp(?:, sp)?, #(\d+)", code):
            function["frame"] += int(shift[1])
        elif call := CALL.match(code):
            # A jump to the inside of a function is one of its own.
            if (to := int(call[1], 16)) != address and to in found:
                function["calls"].add(to)
        elif code.startswith("\tblx\tr"):
            function["pointers"] += 1
    return found


def deepest(found, address, above=()):
    """Bytes and the path."""
    function = found[address]
    if address in above:
        return 0, [(0, f"recursion to {function['name']}", 0)]
    if "deepest" not in function:
        below = [deepest(found, call, (*above, address)) for call in function["calls"]]
        depth, path = max(below, default=(0, []), key=lambda pair: pair[0])
        own = (function["frame"], function["name"], function["pointers"])
        function["deepest"] = function["frame"] + depth, [own, *path]
    return function["deepest"]


def told(found, roots):
    """Prints the deepest path of each root; the sum of all."""
    total = 0
    for address in roots:
        depth, path = deepest(found, address)
        total += depth
        print(f"{depth} B from {found[address]['name']}")
        for frame, name, pointers in path:
            print(f"  {frame:6} {name[:150]}{f', {pointers} calls by pointer' if pointers else ''}")
    return total


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("image")
    parser.add_argument("--most", type=int)
    parser.add_argument("function", nargs="*")
    given = parser.parse_args()
    found = functions(given.image)
    if given.function:
        told(found, [at for at, has in found.items() if any(name in has["name"] for name in given.function)])
        return
    named = {function["name"]: address for address, function in found.items()}
    # The board: program, tick, line.
    roots = [named[name] for name in ("main", "SysTick", "TIM7", "UART0_RX", "USART2") if name in named]
    # On a board whose tick is a timer, SysTick has the common handler.
    roots = [root for root in roots if found[root]["name"] != "SysTick" or "TIM7" not in named]
    total = told(found, roots) + (len(roots) - 1) * EXCEPTION
    print(f"{total} B in all")
    sys.exit(given.most is not None and total > given.most)


if __name__ == "__main__":
    main()
