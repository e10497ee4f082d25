// Light or dark: as the system says, until the reader chooses.

import type { Theme } from '../view/palette';

const KEY = 'ishigaki-theme';
const system = matchMedia('(prefers-color-scheme: dark)');

export function watchTheme(changed: (theme: Theme) => void): { toggle: () => void } {
  let chosen = read();
  const apply = (): void => {
    const theme = chosen ?? (system.matches ? 'dark' : 'light');
    document.documentElement.dataset.theme = theme;
    changed(theme);
  };
  system.addEventListener('change', apply);
  apply();
  return {
    toggle: () => {
      chosen = document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark';
      write(chosen);
      apply();
    },
  };
}

// Pages opened from a disk may have no storage.
function read(): Theme | null {
  try {
    const kept = localStorage.getItem(KEY);
    return kept === 'dark' || kept === 'light' ? kept : null;
  } catch {
    return null;
  }
}

function write(theme: Theme): void {
  try {
    localStorage.setItem(KEY, theme);
  } catch {
    // Then the choice lasts as long as the page.
  }
}
