// Bundles the pages and builds the manual: node scripts/build.mjs [--out DIR] (default: ../build/web); the labelling page beside DIR. --reference DIR: pages of the
// library's headers, which become part of the manual. The service worker comes last, since it lists the files of the phone's page and carries their digest as
// its version.
import { build } from 'esbuild';
import { createHash } from 'node:crypto';
import { cpSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const web = join(dirname(fileURLToPath(import.meta.url)), '..');
const out = option('--out') ?? join(web, '../build/web');

const common = { bundle: true, minify: true, target: ['es2021', 'safari15', 'chrome100'], logLevel: 'warning' };

rmSync(out, { recursive: true, force: true });
mkdirSync(out, { recursive: true });
cpSync(join(web, 'static'), out, { recursive: true });
// The pages differ in their code and style alone; the helper's is the one at "/".
for (const [file, page] of [['index', 'helper'], ['device', 'device'], ['pair', 'pair'], ['staff', 'staff']]) {
  writeFileSync(join(out, `${file}.html`), readFileSync(join(web, 'src/page.html'), 'utf8').replaceAll('PAGE', page));
}
cpSync(join(web, 'node_modules/three/LICENSE'), join(out, 'js/three-license.txt'));
await build({
  ...common,
  entryPoints: ['device', 'helper', 'pair', 'staff'].map((page) => ({ in: join(web, `src/${page}/main.ts`), out: `js/${page}` })),
  format: 'esm',
  splitting: true,
  chunkNames: 'js/part-[hash]',
  legalComments: 'none', // three's licence lies beside its code
  outdir: out,
});
await build({
  ...common,
  entryPoints: ['device', 'helper', 'manual', 'pair', 'staff'].map((page) => ({ in: join(web, `src/styles/${page}.css`), out: `css/${page}` })),
  outdir: out,
});

// The laboratory's page is opened as a file, which may load no modules.
const labelling = join(out, '../labelling');
rmSync(labelling, { recursive: true, force: true });
await build({
  ...common,
  entryPoints: [{ in: join(web, 'src/labelling/main.ts'), out: 'labelling' }, { in: join(web, 'src/styles/labelling.css'), out: 'labelling' }],
  format: 'iife',
  outdir: labelling,
});
cpSync(join(web, 'src/labelling/page.html'), join(labelling, 'index.html'));

const { buildManual } = await compiledForNode('src/manual/site.ts');
buildManual(join(web, '..'), join(out, 'help'), option('--reference'));

const shell = ['device.html', 'pair.html', 'css/device.css', 'css/pair.css', 'js/device.js', 'js/pair.js',
  'manifest.webmanifest', 'icons/icon.svg', 'icons/icon-192.png', ...importedParts(['js/device.js', 'js/pair.js'])];
const digest = createHash('sha256');
for (const file of shell) {
  digest.update(readFileSync(join(out, file)));
}
await build({
  ...common,
  entryPoints: [{ in: join(web, 'src/service_worker/service_worker.ts'), out: 'service_worker' }],
  format: 'iife',
  outdir: out,
  define: {
    SHELL_VERSION: JSON.stringify(digest.digest('hex').slice(0, 16)),
    SHELL_FILES: JSON.stringify(shell.map((file) => '/' + file)),
  },
});

// The folder that an option names.
function option(name) {
  const at = process.argv.indexOf(name);
  return at < 0 ? undefined : resolve(process.argv[at + 1] ?? '');
}

// A module of the sources that runs here. It lies beside node_modules, where its libraries are found.
async function compiledForNode(source) {
  const outfile = join(web, `node_modules/.roomwise/build-${process.pid}.mjs`);
  await build({
    entryPoints: [join(web, source)],
    outfile,
    bundle: true,
    packages: 'external',
    platform: 'node',
    format: 'esm',
    target: 'node18',
    logLevel: 'warning',
  });
  try {
    return await import(pathToFileURL(outfile));
  } finally {
    rmSync(outfile);
  }
}

// What the scripts load at once, not what they load later.
function importedParts(files) {
  const found = new Set();
  const look = (file) => {
    for (const [, part] of readFileSync(join(out, file), 'utf8').matchAll(/(?:from|import)"\.\/(part-\w+\.js)"/g)) {
      if (!found.has(`js/${part}`)) {
        found.add(`js/${part}`);
        look(`js/${part}`);
      }
    }
  };
  files.forEach(look);
  return [...found].sort();
}
