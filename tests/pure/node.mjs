// Runs a program for WASI that is given no folder, no argument and no variable, and refuses one that could open, listen or read a clock.
import { readFile } from 'node:fs/promises'
import { argv, exit } from 'node:process'
import { WASI } from 'node:wasi'

// Seeds of hash maps, words, the end of the program, and a thread that waits for itself.
const harmless = ['environ_get', 'environ_sizes_get', 'fd_write', 'proc_exit', 'random_get', 'sched_yield']

const program = await WebAssembly.compile(await readFile(argv[2]))
const others = WebAssembly.Module.imports(program).filter(({ name }) => !harmless.includes(name))
if (others.length > 0) {
  console.error(`not pure, it imports ${others.map(({ name }) => name).join(', ')}`)
  exit(1)
}
const wasi = new WASI({ version: 'preview1', args: ['answers'] })
exit(wasi.start(await WebAssembly.instantiate(program, wasi.getImportObject())))
