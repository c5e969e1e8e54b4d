// Where the pages of a home among many lie.
export function pathsOf(home: string): { helper: string; device: string } {
  const base = `/homes/${encodeURIComponent(home)}`;
  return { helper: `${base}/`, device: `${base}/device` };
}
