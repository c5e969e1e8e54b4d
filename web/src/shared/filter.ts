// Finding names by what was typed: anywhere in the name, whatever the case and accents. Pure.

export function folded(words: string): string {
  return words.normalize('NFD').replace(/\p{Diacritic}/gu, '').toLowerCase().trim();
}

export function matches(name: string, typed: string): boolean {
  return folded(name).includes(folded(typed));
}

export function matching(names: readonly string[], typed: string): string[] {
  return names.filter((name) => matches(name, typed));
}
