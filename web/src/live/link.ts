// The page's state in its address: `#scene=tower&n=20&a=solver:plain&b=…&show=contacts&color=height`.

import type { Engine, Source } from './engine';
import { OVERLAYS, type Changes, type OverlayName, type Session, type Side } from './session';
import { COLOR_MODES, type ColorMode } from '../view/palette';

export interface Link {
  scene: string;
  parameters: Record<string, number>;
  changes: Changes[];
  overlays: OverlayName[];
  color: ColorMode;
  paused: boolean;
}

const DEFAULT_SCENE = 'wall';

export function readLink(fragment: string, engine: Engine): Link {
  const query = new URLSearchParams(fragment.replace(/^#/, ''));
  const scene = query.get('scene') ?? DEFAULT_SCENE;
  const known = engine.scenes.find((s) => s.name === scene);
  const parameters: Record<string, number> = {};
  for (const { name } of known?.parameters ?? []) {
    const value = query.get(name);
    if (value !== null && value !== '') parameters[name] = Number(value);
  }
  const list = (side: string): Changes =>
    query.getAll(side).flatMap((text): Changes => {
      const at = text.indexOf(':');
      return at > 0 ? [[text.slice(0, at), text.slice(at + 1)]] : [];
    });
  const shown = (query.get('show') ?? '').split(',');
  return {
    scene,
    parameters,
    changes: query.has('b') || query.get('view') === 'compare' ? [list('a'), list('b')] : [list('a')],
    overlays: OVERLAYS.map(({ id }) => id).filter((id) => shown.includes(id)),
    color: COLOR_MODES.find(({ id }) => id === query.get('color'))?.id ?? 'stone',
    paused: query.get('paused') === '1',
  };
}

/** Files are not part of a link: it then names the default scene. */
export function writeLink(session: Session, engine: Engine): string {
  const query = new URLSearchParams();
  const source: Source = session.source;
  if ('scene' in source) {
    query.set('scene', source.scene);
    for (const [name, value] of Object.entries(source.parameters)) query.set(name, String(value));
  }
  session.sides.forEach((side, i) => {
    for (const [path, value] of shortest(side, engine)) query.append('ab'[i] ?? 'b', `${path}:${value}`);
  });
  if (session.sides.length === 2) query.set('view', 'compare');
  if (session.overlays.size > 0) query.set('show', [...session.overlays].join());
  if (session.colorMode !== 'stone') query.set('color', session.colorMode);
  return `#${query.toString().replaceAll('%3A', ':').replaceAll('%2C', ',')}`;
}

/** What a configuration changes: options, or a preset of the solver and what differs from it, if that is shorter. */
export function shortest({ options, base }: Side, { presets }: Engine): Changes {
  const differing = (from: (path: string) => string | undefined): Changes =>
    // The plot switches this one on.
    [...options].filter(([path, value]) => from(path) !== value && path !== 'report.residual_by_sweep');
  let best = differing((path) => base.get(path));
  for (const [name, preset] of presets) {
    const rest = differing((path) => (path.startsWith('solver.') ? preset.get(path) : base.get(path)));
    if (rest.length + 1 < best.length) best = [['solver', name], ...rest];
  }
  return best;
}

/** `plain, weight amplification`: what a configuration changes, in a few words. */
export function describe(changes: Changes): string {
  if (changes.length === 0) return 'default';
  const words = changes.map(([path, value]) => {
    if (path === 'solver') return value;
    const name = path
      .replace(/^(solver|rest|motion)\./, '')
      .replace(/\.enabled$/, '')
      .replace(/[._]/g, ' ');
    if (path.endsWith('.enabled')) return value === 'true' ? name : `no ${name}`;
    return `${name} ${value.replaceAll('_', ' ')}`;
  });
  return words.length > 3 ? `${words.slice(0, 2).join(', ')} and ${words.length - 2} more` : words.join(', ');
}
