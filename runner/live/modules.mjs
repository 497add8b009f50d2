// Modules of WebAssembly: how they travel, and the memory that one has.

const STACK = 1 << 20; // bytes
export const LINE = 64;
export const PAGE = 1 << 16;

/** @param {string} text  gzipped and in base 64 */
export async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The modules of before, which stay where only numbers change. @type {Map<string, Promise<WebAssembly.Module>>} */
let kept = new Map();

/** @param {string[]} texts */
export function compiled(texts) {
  kept = new Map(texts.map((text) => [text, kept.get(text) ?? unpacked(text).then((code) => WebAssembly.compile(code))]));
  return Promise.all(texts.map((text) => /** @type {Promise<WebAssembly.Module>} */ (kept.get(text))));
}

/** @param {number} address */
export const aligned = (address) => Math.ceil(address / LINE) * LINE;

/** A module with a memory of its own: its constants, its stack, and from `base` on what the caller keeps there.
 * @param {WebAssembly.Module} module @param {string} entry @param {number} own  bytes of constants
 * @param {number} bytes  of the caller */
export function instantiated(module, entry, own, bytes) {
  const base = aligned(aligned(own) + STACK);
  const memory = new WebAssembly.Memory({ initial: Math.ceil((base + bytes) / PAGE) });
  const pointer = new WebAssembly.Global({ value: "i32", mutable: true }, base);
  const env = { __linear_memory: memory, __stack_pointer: pointer };
  const instance = new WebAssembly.Instance(module, { env });
  return { base, memory, entry: /** @type {Function} */ (instance.exports[entry]) };
}
