/* What emitted C takes of the C library, declared: clang's front end for MSVC parses with it where there is no MSVC. */
#ifndef MSVC_MATH_H
#define MSVC_MATH_H
float sinf(float x);
float cosf(float x);
float sqrtf(float x);
float fabsf(float x);
float fmaf(float x, float y, float z);
float tanhf(float x);
double sin(double x);
double cos(double x);
double sqrt(double x);
double fabs(double x);
double fma(double x, double y, double z);
double tanh(double x);
#endif
