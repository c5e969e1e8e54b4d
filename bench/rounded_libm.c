// To be loaded before libm (LD_PRELOAD): the functions of it that mapping calls, computed with more digits than are asked
// for and rounded once, so that the last bit is the same on every processor in all but a few cases of a thousand million.
// Tells whether results of two processors differ by their libm, whose last bit depends on fused multiplications.
//   cc -shared -fPIC -O2 -fno-builtin -ffp-contract=off -o rounded.so bench/rounded_libm.c -lm
#include <math.h>

#define OF_ONE(name) \
  double name(double x) { return (double)name##l((long double)x); } \
  float name##f(float x) { return (float)name##l((long double)x); }
#define OF_TWO(name) \
  double name(double x, double y) { return (double)name##l((long double)x, (long double)y); } \
  float name##f(float x, float y) { return (float)name##l((long double)x, (long double)y); }

OF_ONE(sin)
OF_ONE(cos)
OF_ONE(tan)
OF_ONE(asin)
OF_ONE(acos)
OF_ONE(atan)
OF_ONE(exp)
OF_ONE(log)
OF_ONE(log1p)
OF_ONE(sinh)
OF_ONE(cosh)
OF_TWO(atan2)
OF_TWO(pow)
OF_TWO(hypot)

void sincos(double x, double* s, double* c) {
  *s = sin(x);
  *c = cos(x);
}
void sincosf(float x, float* s, float* c) {
  *s = sinf(x);
  *c = cosf(x);
}
