// The name of a device, and which field a refusal is about. Pure.

export const kMaxNameBytes = 64; // as UTF-8

export function fitsAsName(name: string): boolean {
  return new TextEncoder().encode(name).byteLength <= kMaxNameBytes;
}

// Only a code that does not hold is about the code; a wrong value (400) names its member. Null: about no field.
export function fieldOf(status: number, message: string): 'code' | 'name' | null {
  if (status === 401 || status === 403) {
    return 'code';
  }
  const member = status === 400 ? /'(code|name)'/.exec(message)?.[1] : undefined;
  return member === 'code' || member === 'name' ? member : null;
}
