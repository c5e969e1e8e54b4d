// Pictures of made-up rooms, drawn by a few rules: a floor, two walls, furniture.
import { crc32, deflateSync } from '../scripts/png_parts.mjs';

type Colour = readonly [number, number, number];

const kWidth = 320;
const kHeight = 240;
const kWalls: Record<string, Colour> = {
  kitchen: [238, 222, 186], corridor: [221, 219, 212], bathroom: [196, 222, 230], bedroom: [226, 211, 224],
};
const kFurniture: Colour[] = [[126, 84, 52], [70, 96, 120], [150, 60, 52], [92, 120, 84], [230, 230, 226]];

export function drawnRoom(room: string, view: number): Buffer {
  const wall = kWalls[room] ?? [210, 210, 210];
  const corner = 60 + ((view * 47) % 200);
  const rows = Buffer.alloc(kHeight * (1 + 3 * kWidth));
  for (let y = 0; y < kHeight; y += 1) {
    for (let x = 0; x < kWidth; x += 1) {
      const colour = at(x, y, view, corner, wall);
      colour.forEach((value, channel) => (rows[y * (1 + 3 * kWidth) + 1 + 3 * x + channel] = value));
    }
  }
  return png(rows);
}

function at(x: number, y: number, view: number, corner: number, wall: Colour): Colour {
  for (let i = 0; i < 3; i += 1) {
    const left = (view * 61 + i * 113) % 300;
    const [width, top] = [40 + ((view * 13 + i * 29) % 60), 110 + ((view * 7 + i * 31) % 50)];
    if (x >= left && x < left + width && y >= top && y < top + 85) {
      return shaded(kFurniture[(view + i) % kFurniture.length] as Colour, x < left + 6 || y < top + 6 ? 1.2 : 1);
    }
  }
  const floor = 170 + Math.abs(x - corner) / 6;
  if (y > floor) {
    return shaded([172, 140, 104], (x + 2 * y) % 40 < 2 ? 0.85 : 1);
  }
  return shaded(wall, x < corner ? 0.9 : 1);
}

function shaded(colour: Colour, by: number): Colour {
  return colour.map((value) => Math.min(255, Math.round(value * by))) as unknown as Colour;
}

function png(rows: Buffer): Buffer {
  const size = Buffer.alloc(13);
  size.writeUInt32BE(kWidth, 0);
  size.writeUInt32BE(kHeight, 4);
  size.set([8, 2, 0, 0, 0], 8);
  const chunk = (name: string, data: Buffer): Buffer => {
    const body = Buffer.concat([Buffer.from(name, 'latin1'), data]);
    const framed = Buffer.alloc(body.length + 8);
    framed.writeUInt32BE(data.length, 0);
    body.copy(framed, 4);
    framed.writeUInt32BE(crc32(body), body.length + 4);
    return framed;
  };
  return Buffer.concat([
    Buffer.from('\x89PNG\r\n\x1a\n', 'latin1'), chunk('IHDR', size), chunk('IDAT', deflateSync(rows)),
    chunk('IEND', Buffer.alloc(0)),
  ]);
}
