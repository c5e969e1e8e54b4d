// The manual: docs/ as pages that are browsed without a network, under help/ of the web pages. docs/manual/contents.json
// says which chapters there are, in which order; every other page of docs/ is reached from them.
import { spawnSync } from 'node:child_process';
import { cpSync, existsSync, mkdirSync, readdirSync, readFileSync, writeFileSync } from 'node:fs';
import { dirname, join, posix } from 'node:path';

import { addressOf, relativeAddress, type Repository } from './links';
import { readPage, type Page } from './markdown';

export interface Chapter {
  file: string; // below docs/
  about: string;
  language?: string; // of the page, where it is not English
  spoken?: boolean; // has a recording of the page read aloud beside it
}

export interface Contents {
  title: string;
  groups: Group[];
}

export interface Group {
  title: string;
  chapters: Chapter[];
  reference?: boolean; // ends with the pages of the library's headers, where they are there
}

const kReference = 'reference/index.html';

// root: of the repository. reference: the folder with the pages of the library's headers, if they are to be part of it. Throws where a
// link, an anchor or a chapter is not there.
export function buildManual(root: string, out: string, reference?: string): void {
  const contents = JSON.parse(readFileSync(join(root, 'docs/manual/contents.json'), 'utf8')) as Contents;
  for (const group of contents.groups) {
    group.reference &&= reference !== undefined;
  }
  const files = markdownUnder(join(root, 'docs')).map((file) => `docs/${file}`);
  const repository: Repository = {
    isPage: (file) => files.includes(file),
    exists: (path) => existsSync(join(root, path)),
  };
  const pages = files.map((file) => readPage(file, readFileSync(join(root, file), 'utf8'), repository));
  checkLinks(pages);
  const chapters = contents.groups.flatMap((group) => group.chapters);
  checkChapters(chapters, pages);
  const titles = new Map(pages.map((page) => [page.file, page.title]));
  for (const page of pages) {
    const chapter = chapters.find((one) => `docs/${one.file}` === page.file);
    write(join(out, addressOf(page.file)), pageHtml(page, chapter, contents, titles));
    page.pictures.forEach((picture) => cpSync(join(root, picture), join(out, addressOf(picture))));
    if (chapter?.spoken) {
      readAloud(page.plain, chapter.language ?? 'en', join(out, recordingOf(page.file)));
    }
  }
  write(join(out, 'index.html'), indexHtml(contents, titles));
  if (reference !== undefined) {
    cpSync(reference, dirname(join(out, kReference)), { recursive: true });
  }
}

export function checkLinks(pages: readonly Page[]): void {
  for (const page of pages) {
    for (const link of page.links) {
      const target = pages.find((one) => one.file === link.file);
      if (link.anchor !== '' && !target?.anchors.includes(link.anchor)) {
        throw new Error(`${page.file}: a link leads to ${link.href}, but ${link.file} has no heading '${link.anchor}'`);
      }
    }
  }
}

// Every chapter is a page, and every page can be reached from a chapter.
export function checkChapters(chapters: readonly Chapter[], pages: readonly Page[]): void {
  const reached = new Set<string>();
  const visit = (file: string): void => {
    if (!reached.has(file)) {
      reached.add(file);
      pages.find((page) => page.file === file)?.links.forEach((link) => visit(link.file));
    }
  };
  for (const { file } of chapters) {
    if (!pages.some((page) => page.file === `docs/${file}`)) {
      throw new Error(`docs/manual/contents.json: there is no docs/${file}`);
    }
    visit(`docs/${file}`);
  }
  const lost = pages.filter((page) => !reached.has(page.file)).map((page) => page.file);
  if (lost.length > 0) {
    throw new Error(`no chapter of docs/manual/contents.json leads to ${lost.join(', ')}`);
  }
}

function markdownUnder(folder: string): string[] {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => (entry.isDirectory()
    ? markdownUnder(join(folder, entry.name)).map((file) => posix.join(entry.name, file))
    : entry.name.endsWith('.md') ? [entry.name] : [])).sort();
}

function write(file: string, text: string): void {
  mkdirSync(dirname(file), { recursive: true });
  writeFileSync(file, text);
}

function recordingOf(file: string): string {
  return addressOf(file).replace(/\.html$/, '.mp3');
}

const kWordsAMinute = 150;

// MP3, since every browser plays it and WAV is twenty times as large.
function readAloud(words: string, language: string, file: string): void {
  const speech = run('espeak-ng', ['-v', language, '-s', String(kWordsAMinute), '--stdin', '--stdout'], words);
  writeFileSync(file, run('lame', ['--quiet', '-m', 'm', '-b', '32', '-', '-'], speech));
}

function run(program: string, options: readonly string[], input: string | Buffer): Buffer {
  const { error, status, stdout, stderr } = spawnSync(program, options, { input, maxBuffer: 1 << 28 });
  if (error || status !== 0) {
    throw new Error(`the manual is read aloud by ${program}, which ${error ? `cannot be started (${error.message}); install it` : `failed: ${stderr}`}`);
  }
  return stdout;
}

function escaped(text: string): string {
  return text.replace(/[&<>"]/g, (sign) => ({ '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;' })[sign] ?? sign);
}

interface Frame {
  title: string;
  language: string;
  styles: string; // where the style sheet lies, from the page
  start: string; // where the manual begins, from the page
  navigation: string;
  main: string;
}

function frameHtml(frame: Frame): string {
  return `<!doctype html>
<html lang="${frame.language}">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>${escaped(frame.title)}</title>
<link rel="stylesheet" href="${frame.styles}">
</head>
<body>
<a class="skip" href="#content" lang="en">Skip to the content</a>
<header lang="en"><a href="${frame.start}">Roomwise: the manual</a></header>
<div class="columns">
${frame.navigation}<main id="content" tabindex="-1">
${frame.main}</main>
</div>
</body>
</html>
`;
}

function chapterItem(chapter: Chapter, href: string, title: string, here: boolean): string {
  const language = chapter.language ? ` lang="${chapter.language}" hreflang="${chapter.language}"` : '';
  return `<li><a href="${href}"${language}${here ? ' aria-current="page"' : ''}>${escaped(title)}</a>`;
}

function referenceItem(href: string): string {
  return `<li><a href="${href}">The library's headers</a>`;
}

function groupHtml(group: Group, list: string, items: readonly string[]): string {
  return `<h2>${escaped(group.title)}</h2>\n${list}\n${items.join('\n')}\n</ul>`;
}

function pageHtml(page: Page, chapter: Chapter | undefined, contents: Contents, titles: ReadonlyMap<string, string>): string {
  const groups = contents.groups.map((group) => groupHtml(group, '<ul>', [
    ...group.chapters.map((one) => {
      const file = `docs/${one.file}`;
      return `${chapterItem(one, relativeAddress(page.file, addressOf(file)), titles.get(file) ?? '', file === page.file)}</li>`;
    }),
    ...(group.reference ? [`${referenceItem(relativeAddress(page.file, kReference))}</li>`] : []),
  ]));
  const recording = chapter?.spoken
    ? `<audio controls preload="none" src="${posix.basename(recordingOf(page.file))}" aria-label="${escaped(page.title)}"></audio>\n`
    : '';
  return frameHtml({
    title: `${page.title} – Roomwise`,
    language: chapter?.language ?? 'en',
    styles: relativeAddress(page.file, '../css/manual.css'),
    start: relativeAddress(page.file, 'index.html'),
    navigation: `<nav lang="en" aria-label="Chapters">\n${groups.join('\n')}\n</nav>\n`,
    main: page.html.replace('</h1>\n', `</h1>\n${recording}`),
  });
}

function indexHtml(contents: Contents, titles: ReadonlyMap<string, string>): string {
  const groups = contents.groups.map((group) => groupHtml(group, '<ul class="chapters">', [
    ...group.chapters.map((chapter) => {
      const file = `docs/${chapter.file}`;
      return `${chapterItem(chapter, addressOf(file), titles.get(file) ?? '', false)}. ${escaped(chapter.about)}</li>`;
    }),
    ...(group.reference ? [`${referenceItem(kReference)}. Every class and function that programs can use.</li>`] : []),
  ]));
  return frameHtml({
    title: contents.title,
    language: 'en',
    styles: '../css/manual.css',
    start: 'index.html',
    navigation: '',
    main: `<h1>${escaped(contents.title)}</h1>\n${groups.join('\n')}\n`,
  });
}
