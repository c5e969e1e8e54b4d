// node scripts/run_tests.mjs unit|browser|whole [OPTIONS]: compiles the tests and runs them by node's test runner, whose
// options may follow (--test-name-pattern=hazard). whole: with the real programs; ROOMWISE_PROGRAM names roomwise.
// node scripts/run_tests.mjs try [PORT]: serves the built pages with a made-up home, for looking at.
// node scripts/run_tests.mjs screenshots FOLDER: pictures of every page, small and large, light and dark.
// ROOMWISE_WEB: the folder of the built pages (default: ../build/web).
import { build } from 'esbuild';
import { spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, readdirSync, rmSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const web = join(dirname(fileURLToPath(import.meta.url)), '..');
const [kind = 'unit', ...rest] = process.argv.slice(2);
const pages = resolve(process.env.ROOMWISE_WEB ?? join(web, '../build/web'));

function testsUnder(folder) {
  return readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const path = join(folder, entry.name);
    if (entry.isDirectory()) {
      return testsUnder(path);
    }
    return entry.name.endsWith('_test.ts') ? [path] : [];
  });
}

const sources = {
  unit: () => testsUnder(join(web, 'src')),
  browser: () => testsUnder(join(web, 'test/browser')),
  whole: () => testsUnder(join(web, 'test/whole')),
  screenshots: () => [join(web, 'test/screenshots.ts')],
  try: () => [join(web, 'test/try_pages.ts')],
}[kind]?.();
if (!sources) {
  console.error(`unknown kind of tests '${kind}'; unit, browser, whole, try or screenshots`);
  process.exit(2);
}
if (kind !== 'unit' && !existsSync(join(pages, 'index.html'))) {
  console.error(`no pages in ${pages}; build them first (npm run build), or name their folder in ROOMWISE_WEB`);
  process.exit(2);
}

if (kind === 'whole' && !existsSync(process.env.ROOMWISE_PROGRAM ?? '')) {
  console.error('name the program roomwise in ROOMWISE_PROGRAM, for example ../build/release/bin/roomwise');
  process.exit(2);
}

// Beside node_modules, where the tests' libraries are found.
const compiled = join(web, 'node_modules/.roomwise', `${kind}-${process.pid}`);
rmSync(compiled, { recursive: true, force: true });
mkdirSync(compiled, { recursive: true });
let status = 1;
try {
  // One entry, so that browser tests share one browser and run one after the other.
  await build({
    stdin: { contents: sources.map((file) => `import ${JSON.stringify(file)};`).join('\n'), resolveDir: web },
    outfile: join(compiled, 'tests.mjs'),
    bundle: true,
    packages: 'external',
    platform: 'node',
    format: 'esm',
    target: 'node18',
    sourcemap: 'inline',
    logLevel: 'warning',
  });
  const script = join(compiled, 'tests.mjs');
  const isTest = ['unit', 'browser', 'whole'].includes(kind);
  status = spawnSync(process.execPath, ['--enable-source-maps', ...(isTest ? ['--test', ...rest, script] : [script, ...rest])], {
    stdio: 'inherit',
    env: { ...process.env, ROOMWISE_WEB: pages },
  }).status ?? 1;
} finally {
  rmSync(compiled, { recursive: true, force: true });
}
process.exit(status);
