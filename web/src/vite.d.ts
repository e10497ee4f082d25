/** The engine's wasm file, gzipped, in base64; see vite.config.mjs. */
declare module 'virtual:engine' {
  const packed: string;
  export default packed;
}
