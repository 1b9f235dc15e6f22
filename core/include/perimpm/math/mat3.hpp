#pragma once

#include "perimpm/math/simd.hpp"

namespace perimpm {

/// 3x3 matrix of numbers or packs, row-major.
template <class T>
struct Mat3 {
    T m[9];

    T& operator()(int row, int column) { return m[3 * row + column]; }
    const T& operator()(int row, int column) const { return m[3 * row + column]; }

    static Mat3 identity() { return {T(1), T(0), T(0), T(0), T(1), T(0), T(0), T(0), T(1)}; }
    static Mat3 diagonal(const T& a, const T& b, const T& c) { return {a, T(0), T(0), T(0), b, T(0), T(0), T(0), c}; }
};

template <class T>
Mat3<T> operator*(const Mat3<T>& a, const Mat3<T>& b) {
    Mat3<T> c;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) c(i, j) = a(i, 0) * b(0, j) + a(i, 1) * b(1, j) + a(i, 2) * b(2, j);
    return c;
}

template <class T>
Mat3<T> transpose(const Mat3<T>& a) {
    return {a.m[0], a.m[3], a.m[6], a.m[1], a.m[4], a.m[7], a.m[2], a.m[5], a.m[8]};
}

template <class T>
T determinant(const Mat3<T>& a) {
    return a(0, 0) * (a(1, 1) * a(2, 2) - a(1, 2) * a(2, 1)) - a(0, 1) * (a(1, 0) * a(2, 2) - a(1, 2) * a(2, 0)) +
           a(0, 2) * (a(1, 0) * a(2, 1) - a(1, 1) * a(2, 0));
}

/// Zero for a singular matrix.
template <class T>
Mat3<T> inverse(const Mat3<T>& a) {
    const T det = determinant(a);
    const T scale = det == T(0) ? T(0) : T(1) / det;
    Mat3<T> b;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            const int r = (j + 1) % 3, s = (j + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;
            b(i, j) = scale * (a(r, c) * a(s, d) - a(r, d) * a(s, c));
        }
    return b;
}

}  // namespace perimpm
