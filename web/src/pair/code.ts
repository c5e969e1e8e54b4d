// The secret of a link, behind "#": 22 letters of base64url; null for anything else. Pure.
export function secretFrom(hash: string): string | null {
  return /^#[\w-]{22}$/.test(hash) ? hash.slice(1) : null;
}

// Six digits, however they are written: "#123456", "123 456", "123-456"; null for anything else. Pure.
export function codeFrom(written: string): string | null {
  const digits = written.replace(/^#/, '').replace(/[\s-]/g, '');
  return /^\d{6}$/.test(digits) ? digits : null;
}
