// Which frames of a walk belong to which room. Ranges do not overlap, both ends are included. Pure.
import type { RoomRange } from '../shared/protocol';

// The new range takes its frames from the others; neighbours of one room become one.
export function withRange(ranges: readonly RoomRange[], added: RoomRange): RoomRange[] {
  return joined([...without(ranges, added.first, added.last), added]);
}

export function without(ranges: readonly RoomRange[], first: number, last: number): RoomRange[] {
  return ranges.flatMap((range) => [
    { ...range, last: Math.min(range.last, first - 1) },
    { ...range, first: Math.max(range.first, last + 1) },
  ].filter((part, i) => part.first <= part.last && (i === 0 ? range.first < first : range.last > last)));
}

export function roomAt(ranges: readonly RoomRange[], frame: number): string | null {
  return ranges.find((range) => range.first <= frame && frame <= range.last)?.room ?? null;
}

function joined(ranges: RoomRange[]): RoomRange[] {
  const sorted = [...ranges].sort((a, b) => a.first - b.first);
  const result: RoomRange[] = [];
  for (const range of sorted) {
    const last = result[result.length - 1];
    if (last && last.room === range.room && last.last + 1 === range.first) {
      last.last = range.last;
    } else {
      result.push({ ...range });
    }
  }
  return result;
}

// The frames that a key-frame stands for: from its own to the one before the next key-frame's. To people it is a picture
// of the walk, numbered from 1 on.
export interface FrameSpan {
  keyframe: number;
  first: number;
  last: number;
  time_s: number; // since the walk began
}

export function spansOf(keyframes: readonly { id: number; frame: number; time_s: number }[], frames: number): FrameSpan[] {
  const sorted = [...keyframes].sort((a, b) => a.frame - b.frame);
  return sorted.map(({ id, frame, time_s }, i) => ({
    keyframe: id,
    first: i === 0 ? 0 : frame,
    last: (sorted[i + 1]?.frame ?? Math.max(frames, frame + 1)) - 1,
    time_s: time_s - (sorted[0]?.time_s ?? 0),
  }));
}

// The first and the last picture, by their place in the row, that have frames of the range; null where none has.
export function picturesOf(spans: readonly FrameSpan[], { first, last }: { first: number; last: number }): [number, number] | null {
  const from = spans.findIndex((span) => span.last >= first);
  let to = spans.length - 1;
  while (to >= 0 && (spans[to] as FrameSpan).first > last) {
    to -= 1;
  }
  return from < 0 || to < from ? null : [from, to];
}
