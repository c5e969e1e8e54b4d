// The home in words: rooms with their things, doorways, walks; and what of it fits a search. Pure.
import { matches } from '../shared/filter';
import type { Doorway, Home, Recording, Room, Thing } from '../shared/protocol';

export interface RoomOutline {
  room: Room;
  things: Thing[];
  neighbours: string[]; // by its doorways
}

export interface Outline {
  rooms: RoomOutline[];
  elsewhere: Thing[]; // in no room
  doorways: Doorway[];
  recordings: Recording[];
}

export function outlineOf(home: Home, typed = ''): Outline {
  const fits = (...names: (string | null)[]): boolean => names.some((name) => name !== null && matches(name, typed));
  const byName = (a: { name: string }, b: { name: string }): number => a.name.localeCompare(b.name);
  const thingsIn = (room: string | null): Thing[] => home.things.filter((thing) => thing.room === room).sort(byName);
  const known = new Set(home.rooms.map((room) => room.name));
  return {
    // A room that fits is shown whole, another one with the things that fit.
    rooms: [...home.rooms].sort(byName).flatMap((room) => {
      const whole = fits(room.name, room.type);
      const things = thingsIn(room.name).filter((thing) => whole || fits(thing.name));
      return whole || things.length > 0 ? [{ room, things, neighbours: neighboursOf(home, room.name) }] : [];
    }),
    elsewhere: home.things
      .filter((thing) => (thing.room === null || !known.has(thing.room)) && fits(thing.name))
      .sort(byName),
    doorways: home.doorways.filter((doorway) => fits(...doorway.rooms)),
    recordings: home.recordings.filter((recording) => fits(recording.name)),
  };
}

export function countOf(outline: Outline): { rooms: number; things: number } {
  return {
    rooms: outline.rooms.length,
    things: outline.rooms.reduce((sum, one) => sum + one.things.length, outline.elsewhere.length),
  };
}

function neighboursOf(home: Home, room: string): string[] {
  const across = home.doorways
    .filter((doorway) => doorway.rooms.includes(room))
    .flatMap((doorway) => doorway.rooms.filter((other) => other !== room));
  return [...new Set(across)].sort((a, b) => a.localeCompare(b));
}
