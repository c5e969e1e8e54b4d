// Where links of one page of the manual lead. Paths are relative to the repository, with '/' between names.
import { posix } from 'node:path';

// What the links of a page can point to.
export interface Repository {
  isPage(file: string): boolean; // becomes a page of the manual
  exists(path: string): boolean; // a file or folder of the sources
}

export type Target =
  | { kind: 'outside'; href: string }
  | { kind: 'page'; file: string; anchor: string }
  | { kind: 'picture'; file: string }
  | { kind: 'source'; path: string };

// What `href` on the page `from` means. Throws where it leads nowhere.
export function targetOf(href: string, from: string, repository: Repository): Target {
  if (/^[a-z][a-z+.-]*:/i.test(href)) {
    return { kind: 'outside', href };
  }
  const [path = '', anchor = ''] = href.split('#');
  const file = path === '' ? from : posix.normalize(posix.join(posix.dirname(from), decodeURI(path)));
  if (repository.isPage(file)) {
    return { kind: 'page', file, anchor };
  }
  if (file.startsWith('..') || !repository.exists(file)) {
    throw new Error(`${from}: a link leads to ${href}, which is not there`);
  }
  return /\.(png|jpe?g|svg|webp)$/.test(file) ? { kind: 'picture', file } : { kind: 'source', path: file };
}

// docs/manual/helper.md lies at manual/helper.html in the manual.
export function addressOf(file: string): string {
  return file.replace(/^docs\//, '').replace(/\.md$/, '.html');
}

export function relativeAddress(from: string, to: string): string {
  return posix.relative(posix.dirname(addressOf(from)), to) || posix.basename(to);
}

// As GitHub makes anchors of headings, so that the same links work in both places.
export function anchorOf(heading: string): string {
  return heading.trim().toLowerCase().replace(/[^\p{L}\p{N}\p{M} _-]/gu, '').replace(/ /g, '-');
}
