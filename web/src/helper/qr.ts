// A QR code from its rows of modules, '1' is dark: one path, with the four light modules that readers need around it.
import { svg } from '../shared/svg';

export const kQuiet = 4;

export function qrPath(rows: readonly string[]): { side: number; path: string } {
  let path = '';
  rows.forEach((row, y) => {
    for (const { index, 0: run } of row.matchAll(/1+/g)) {
      path += `M${index + kQuiet} ${y + kQuiet}h${run.length}v1h-${run.length}z`;
    }
  });
  return { side: rows.length + 2 * kQuiet, path };
}

export function qrPicture(rows: readonly string[], label: string): SVGSVGElement {
  const { side, path } = qrPath(rows);
  const element = svg('svg', {
    viewBox: `0 0 ${side} ${side}`, class: 'qr', role: 'img', 'aria-label': label, 'shape-rendering': 'crispEdges',
  });
  // Dark on light in every colour scheme: many readers know nothing else.
  element.append(svg('rect', { width: side, height: side, fill: '#fff' }), svg('path', { d: path, fill: '#000' }));
  return element as SVGSVGElement;
}
