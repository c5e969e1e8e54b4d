// Six digits, however they are written: "#123456", "123 456", "123-456"; null for anything else. Pure.
export function codeFrom(written: string): string | null {
  const digits = written.replace(/^#/, '').replace(/[\s-]/g, '');
  return /^\d{6}$/.test(digits) ? digits : null;
}
