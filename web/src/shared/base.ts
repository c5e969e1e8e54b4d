// Where this home's pages and requests lie: at the root of a computer that serves one home, under /homes/NAME where it
// serves many.
export function baseOf(pathname: string): string {
  return /^\/homes\/[^/]+(?=\/)/.exec(pathname)?.[0] ?? '';
}

// A path of the home as an address of this computer: "/api/me" to "/homes/flat-7/api/me".
export function at(path: string): string {
  return baseOf(typeof location === 'undefined' ? '' : location.pathname) + path;
}
