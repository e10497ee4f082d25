// Files that are dropped or opened: scenes, models, snapshots.

import type { Changes, Session } from './session';

const SNAPSHOT = 'ISHIGAKI';
const RECORDING = '\x89ISHI';
/** Larger ones are no scenes. */
const LARGEST = 256 * 1024 * 1024;

/** Loads a file; says what it was. Throws an `Error` that says what is wrong; then nothing has changed. */
export async function openFile(file: File, session: Session): Promise<string> {
  if (file.size > LARGEST) throw new Error(`${file.name}: ${Math.round(file.size / 1e6)} MB is too large for a scene`);
  const bytes = new Uint8Array(await file.arrayBuffer());
  const mark = String.fromCharCode(...bytes.subarray(0, 8));
  if (mark === SNAPSHOT) {
    session.restoreFrom(bytes);
    return `${file.name}: the snapshot is restored`;
  }
  if (mark.startsWith(RECORDING)) {
    throw new Error(`${file.name}: is a recording; the replay page plays it: ishigaki view ${file.name}`);
  }
  let text: string;
  try {
    text = new TextDecoder('utf-8', { fatal: true }).decode(bytes);
  } catch {
    throw new Error(`${file.name}: is neither a scene (.json), a model (.xml, .urdf) nor a snapshot`);
  }
  try {
    session.load({ file: file.name, text }, session.sides.map((): Changes => []));
  } catch (error) {
    const hint = text.trimStart().startsWith('<') && /cannot be read|not supported|No such file/i.test(String(error));
    throw hint && error instanceof Error
      ? new Error(`${error.message} (the page sees one file only: models whose meshes are in other files run with \`ishigaki run\`)`)
      : error;
  }
  const { name, warnings } = session.first.world.about;
  const more = warnings.length > 0 ? `, with ${warnings.length} remarks: ${warnings[0]}` : '';
  return `${file.name}: ${name || 'the scene'} is loaded${more}`;
}
