// What a person may ask the way to, or find, as the phone lists it. A room may be called as the way out is, or as a thing: each
// entry has its kind, and no two have the same label.
import type { ThingInRooms } from '../shared/protocol';
import { text } from '../shared/texts';

export interface Goal {
  kind: 'spot' | 'way out' | 'room' | 'thing';
  name: string; // as the computer knows it
  room?: string; // of several things of that name the one there
  label: string; // as it is listed
}

export interface Known {
  spots: readonly string[];
  rooms: readonly string[];
  things: readonly string[];
  thingsInRooms?: readonly ThingInRooms[];
}

// The way out always: who asks where none is known hears who can add it. A spot or a thing that is called so is the way out,
// and a thing that is called as a spot is that spot: so the computer understands these names.
export function goalsOf({ spots, rooms, things, thingsInRooms = [] }: Known, wayOut: string, called: (room: string) => string = (room) => room): Goal[] {
  const labels = roomLabels([...rooms, ...thingsInRooms.flatMap((one) => one.rooms)], called);
  const labelOf = (room: string): string => labels.get(room) ?? room;
  const goals: Goal[] = spots.filter((name) => name !== wayOut).map((name) => ({ kind: 'spot', name, label: name }));
  goals.push({ kind: 'way out', name: wayOut, label: wayOut });
  const taken = new Set(goals.map((goal) => goal.label));
  for (const name of new Set(rooms)) {
    goals.push({ kind: 'room', name, label: taken.has(labelOf(name)) ? text('choice.room', { name: labelOf(name) }) : labelOf(name) });
  }
  const listed = new Set(rooms.map(labelOf));
  for (const name of new Set(things)) {
    const several = taken.has(name) ? undefined : thingsInRooms.find((one) => one.thing === name);
    if (several) {
      goals.push(...several.rooms.map((room): Goal => ({ kind: 'thing', name, room, label: `${name}, ${labelOf(room)}` })));
    } else if (!taken.has(name)) {
      goals.push({ kind: 'thing', name, label: listed.has(name) ? text('choice.thing', { name }) : name });
    }
  }
  return goals;
}

// What each room is called; a name that two of them would have is left to neither.
export function roomLabels(rooms: readonly string[], called: (room: string) => string): Map<string, string> {
  const names = [...new Set(rooms)];
  const count = (label: string): number => names.filter((name) => called(name) === label || name === label).length;
  return new Map(names.map((name) => [name, called(name) === name || count(called(name)) === 1 ? called(name) : name]));
}

// By its label; what is typed and not in the list is taken for a thing, and the computer tells what it knows of it.
export function goalCalled(goals: readonly Goal[], label: string): Goal {
  return goals.find((goal) => goal.label === label) ?? { kind: 'thing', name: label, label };
}
