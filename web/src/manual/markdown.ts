// One page of the manual out of its Markdown.
import MarkdownIt, { type PluginSimple } from 'markdown-it';

import { addressOf, anchorOf, relativeAddress, targetOf, type Repository, type Target } from './links';

export interface Page {
  file: string; // docs/manual/helper.md
  title: string;
  html: string;
  plain: string; // as it is read aloud
  anchors: string[];
  links: { file: string; anchor: string; href: string }[]; // to pages
  pictures: string[];
}

type Tokens = ReturnType<MarkdownIt['parse']>;

// Throws where a link leads nowhere, a picture has no words, or the page has no heading.
export function readPage(file: string, markdown: string, repository: Repository): Page {
  const page: Page = { file, title: '', html: '', plain: '', anchors: [], links: [], pictures: [] };
  const reader = new MarkdownIt({ html: false, linkify: false });
  reader.use(wideBlocks);
  const tokens = reader.parse(markdown, {});
  nameHeadings(tokens, page);
  for (const token of tokens) {
    for (const child of token.children ?? []) {
      if (child.type === 'link_open') {
        child.attrSet('href', hrefOf(String(child.attrGet('href')), page, repository));
      } else if (child.type === 'image') {
        placePicture(child, page, repository);
      }
    }
  }
  unlinkSources(tokens);
  if (page.title === '') {
    throw new Error(`${file}: the page has no heading of the first level`);
  }
  page.html = reader.renderer.render(tokens, reader.options, {});
  page.plain = plainOf(tokens);
  return page;
}

function nameHeadings(tokens: Tokens, page: Page): void {
  const uses = new Map<string, number>();
  tokens.forEach((token, i) => {
    if (token.type !== 'heading_open') {
      return;
    }
    const words = (tokens[i + 1]?.children ?? []).map((child) => child.content).join('');
    page.title ||= token.tag === 'h1' ? words : '';
    const anchor = anchorOf(words);
    const count = uses.get(anchor) ?? 0;
    uses.set(anchor, count + 1);
    const own = count === 0 ? anchor : `${anchor}-${count}`;
    token.attrSet('id', own);
    page.anchors.push(own);
  });
}

const kSource = 'source:';

function hrefOf(href: string, page: Page, repository: Repository): string {
  const target: Target = targetOf(href, page.file, repository);
  switch (target.kind) {
    case 'outside':
      return target.href;
    case 'picture':
      page.pictures.push(target.file);
      return relativeAddress(page.file, addressOf(target.file));
    case 'source':
      return kSource + target.path;
    case 'page': {
      page.links.push({ file: target.file, anchor: target.anchor, href });
      const anchor = target.anchor === '' ? '' : `#${target.anchor}`;
      return target.file === page.file && anchor !== '' ? anchor : relativeAddress(page.file, addressOf(target.file)) + anchor;
    }
  }
}

function placePicture(image: Tokens[number], page: Page, repository: Repository): void {
  if (image.content.trim() === '') {
    throw new Error(`${page.file}: the picture ${image.attrGet('src')} has no words for who does not see it`);
  }
  image.attrSet('src', hrefOf(String(image.attrGet('src')), page, repository));
  image.attrSet('loading', 'lazy');
}

// The sources do not lie beside the manual: what leads there is said, not linked.
function unlinkSources(tokens: Tokens): void {
  for (const token of tokens) {
    let depth = 0;
    for (const child of token.children ?? []) {
      if (child.type === 'link_open' && String(child.attrGet('href')).startsWith(kSource)) {
        const path = String(child.attrGet('href')).slice(kSource.length);
        child.tag = 'span';
        child.attrs = [['class', 'source'], ['title', `in the sources: ${path}`]];
        depth += 1;
      } else if (child.type === 'link_close' && depth > 0) {
        child.tag = 'span';
        depth -= 1;
      }
    }
  }
}

// Tables and code may be wider than a phone: they scroll by themselves, by keyboard too.
const wideBlocks: PluginSimple = (reader) => {
  const rules = reader.renderer.rules;
  let tables = 0;
  rules['table_open'] = () => `<div class="wide" role="region" tabindex="0" aria-label="Table ${tables += 1}"><table>\n`;
  rules['table_close'] = () => '</table></div>\n';
  const escape = reader.utils.escapeHtml;
  const block = (tokens: Tokens, i: number): string => `<pre tabindex="0"><code>${escape(tokens[i]?.content ?? '')}</code></pre>\n`;
  rules['fence'] = block;
  rules['code_block'] = block;
};

function plainOf(tokens: Tokens): string {
  return tokens
    .filter((token) => token.type === 'inline')
    .map((token) => (token.children ?? []).map((child) => (child.type === 'softbreak' ? ' ' : child.content)).join(''))
    .map((line) => (/[.!?:]$/.test(line) ? line : `${line}.`))
    .join('\n\n');
}
