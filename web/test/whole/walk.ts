// A simulated walk from a hall into a bathroom, its pictures, and what else can be played from them.
import assert from 'node:assert/strict';
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { inflateSync } from 'node:zlib';

import { Program } from './programs';

export interface Picture {
  color: string; // its file
  depth: string;
  room: string; // that the camera is in: 'hall' or 'toilet'
}

export interface Walk {
  folder: string;
  pictures: Picture[];
}

const kHome = ['--home-seed', '3', '--rooms', 'toilet', '--samples', '1', '--bake-effort', '0.02'];

// Small and coarse: some ten seconds on two cores. Where ROOMWISE_WALK names a folder it is kept there for the next time.
export function simulateWalk(folder: string): Promise<Walk> {
  return simulate(folder, '', '262 262 159.5 119.5 320 240', '--frames', '150');
}

// Somebody else's walk through the same home, with a phone that they hold upright.
export function simulateUprightWalk(folder: string): Promise<Walk> {
  return simulate(folder, '-upright', '280 280 119.5 159.5 240 320', '--frames', '150', '--walk-seed', '2');
}

async function simulate(folder: string, suffix: string, numbers: string, ...words: string[]): Promise<Walk> {
  const camera = join(folder, `camera${suffix}.txt`);
  writeFileSync(camera, `${numbers} 5000\n`);
  const walk = (process.env['ROOMWISE_WALK'] ?? join(folder, 'walk')) + suffix;
  await new Program(folder, ['simulate', ...kHome, '--fps', '4', '--no-fast-turns', '--camera', camera, ...words, '--keep', '-o', walk]).succeeds();
  return readWalk(walk);
}

export function readWalk(folder: string): Walk {
  const files = (list: string): string[] => linesOf(join(folder, list)).map((line) => join(folder, line.split(' ')[1] ?? ''));
  const depth = files('depth.txt');
  const ranges = linesOf(join(folder, 'rooms.txt')).map((line) => line.split(' '));
  const roomOf = (i: number): string => ranges.find(([first, last]) => i >= Number(first) && i <= Number(last))?.[2] ?? '';
  return { folder, pictures: files('rgb.txt').map((color, i) => ({ color, depth: depth[i] ?? '', room: roomOf(i) })) };
}

// Those in the middle of the time in a room.
export function picturesIn(walk: Walk, room: string, count: number): Picture[] {
  const within = walk.pictures.filter((picture) => picture.room === room);
  assert.ok(within.length >= count, `the walk is in the ${room} for ${within.length} pictures`);
  const first = Math.floor((within.length - count) / 2);
  return within.slice(first, first + count);
}

// A recording of somebody who stands still for an hour: one picture a second.
export function standing(walk: Walk, { color, depth }: Picture, folder: string): string {
  mkdirSync(folder);
  copyFileSync(join(walk.folder, 'camera.txt'), join(folder, 'camera.txt'));
  for (const [name, file, ending] of [['rgb', color, color.slice(-4)], ['depth', depth, '.png']] as const) {
    copyFileSync(file, join(folder, name + ending));
    writeFileSync(join(folder, `${name}.txt`), Array.from({ length: 3600 }, (_, second) => `${second}.0 ${name}${ending}\n`).join(''));
  }
  return folder;
}

// Where the camera truly was at each picture: from its frame (x right, y down, z forward) to the home's, z up.
export function posesOf(walk: Walk): { position: number[]; rotation: number[] }[] {
  const poses = new Map(linesOf(join(walk.folder, 'groundtruth.txt')).map((line) => line.split(' ')).map(([time = '', ...numbers]) => [time, numbers.map(Number)]));
  return linesOf(join(walk.folder, 'rgb.txt')).map((line) => {
    const numbers = poses.get(line.split(' ')[0] ?? '');
    assert.ok(numbers, `the walk has no pose for ${line}`);
    return { position: numbers.slice(0, 3), rotation: numbers.slice(3, 7) };
  });
}

// The levels of a grey PNG of 16 bits, row by row.
export function depthOf(file: string): Uint16Array {
  const png = readFileSync(file);
  const [width, height] = [png.readUInt32BE(16), png.readUInt32BE(20)];
  const parts: Buffer[] = [];
  for (let at = 8; at < png.length; at += 12 + png.readUInt32BE(at)) {
    if (png.subarray(at + 4, at + 8).toString() === 'IDAT') {
      parts.push(png.subarray(at + 8, at + 8 + png.readUInt32BE(at)));
    }
  }
  const packed = inflateSync(Buffer.concat(parts));
  const bytes = Buffer.alloc(2 * width * height);
  const at = (x: number, y: number): number => (x < 0 || y < 0 ? 0 : bytes[y * 2 * width + x] ?? 0);
  for (let y = 0; y < height; y += 1) {
    const filter = packed[y * (2 * width + 1)];
    for (let x = 0; x < 2 * width; x += 1) {
      const [left, above, corner] = [at(x - 2, y), at(x, y - 1), at(x - 2, y - 1)];
      const guesses = [0, left, above, (left + above) >> 1, paeth(left, above, corner)];
      bytes[y * 2 * width + x] = (packed[y * (2 * width + 1) + 1 + x] ?? 0) + (guesses[filter ?? 0] ?? 0);
    }
  }
  return Uint16Array.from({ length: width * height }, (_, i) => bytes.readUInt16BE(2 * i));
}

// The PNG specification's predictor.
function paeth(left: number, above: number, corner: number): number {
  const guess = left + above - corner;
  const [l, a, c] = [left, above, corner].map((one) => Math.abs(guess - one)) as [number, number, number];
  return l <= a && l <= c ? left : a <= c ? above : corner;
}

// What a browser plays as its camera, 30 pictures a second: these forth and back, again and again, four a second.
export function writeVideo(pictures: readonly Picture[], file: string): void {
  const slowly = [...pictures, ...[...pictures].reverse()].flatMap((picture) => Array<Picture>(8).fill(picture));
  writeFileSync(file, Buffer.concat(slowly.map(({ color }) => readFileSync(color))));
}

// The rooms of a walk that was recorded from this one being played: which of its pictures each frame is.
export function roomsOf(recorded: string, played: Walk): string[] {
  const rooms = new Map(played.pictures.map(({ color, room }) => [readFileSync(color).toString('base64'), room]));
  return linesOf(join(recorded, 'rgb.txt')).map((line) => {
    const room = rooms.get(readFileSync(join(recorded, line.split(' ')[1] ?? '')).toString('base64'));
    assert.ok(room, `${line} is no picture of the walk that was played`);
    return room;
  });
}

function linesOf(file: string): string[] {
  return readFileSync(file, 'utf8').split('\n').filter((line) => line !== '' && !line.startsWith('#'));
}
