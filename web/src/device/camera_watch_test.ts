import assert from 'node:assert/strict';
import { test } from 'node:test';

import { CameraWatch, type CameraTrouble } from './camera_watch';

// What is said while pictures of one kind come, four a second.
function watch(camera: CameraWatch, trouble: CameraTrouble | null, fromS: number, toS: number): string[] {
  const said: string[] = [];
  for (let now = fromS * 1000; now < toS * 1000; now += 250) {
    const news = camera.see(trouble, now);
    if (news) {
      said.push(`${news} at ${now / 1000}`);
    }
  }
  return said;
}

test('darkness is said once, and that it is over', () => {
  const camera = new CameraWatch();
  assert.deepEqual(watch(camera, null, 0, 5), []);
  assert.deepEqual(watch(camera, 'dark', 5, 60), ['dark at 6.25']);
  assert.equal(camera.troubled, 'dark');
  assert.deepEqual(watch(camera, null, 60, 70), ['better at 61.5']);
  assert.deepEqual(watch(camera, 'dark', 70, 75), ['dark at 71.25']);
});

test('what is over at once is not said', () => {
  const camera = new CameraWatch();
  assert.deepEqual(watch(camera, 'covered', 0, 1), []);
  assert.deepEqual(watch(camera, null, 1, 1.5), []);
  assert.deepEqual(watch(camera, 'covered', 1.5, 2.5), []);
});

test('a short good moment does not make it worth saying again', () => {
  const camera = new CameraWatch();
  assert.deepEqual(watch(camera, 'dark', 0, 3), ['dark at 1.25']);
  assert.deepEqual(watch(camera, null, 3, 4), []);
  assert.deepEqual(watch(camera, 'dark', 4, 20), []);
});

test('one trouble that turns into another is not said twice', () => {
  const camera = new CameraWatch();
  assert.deepEqual(watch(camera, 'covered', 0, 3), ['covered at 1.25']);
  assert.deepEqual(watch(camera, 'dark', 3, 10), []);
});

test('a blur must last longer, and its end is not spoken of', () => {
  const camera = new CameraWatch();
  assert.deepEqual(watch(camera, 'blurred', 0, 5), ['blurred at 2.5']);
  assert.deepEqual(watch(camera, null, 5, 10), []);
  assert.equal(camera.troubled, null);
});

test('pictures that stay away are said, also after dark ones, and that they are back', () => {
  const camera = new CameraWatch();
  assert.deepEqual(watch(camera, 'dark', 0, 3), ['dark at 1.25']);
  assert.deepEqual(watch(camera, 'failed', 3, 10), ['failed at 4.25']);
  assert.deepEqual(watch(camera, null, 10, 15), ['better at 11.5']);
});
