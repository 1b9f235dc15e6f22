#include "perimpm/math/bspline.hpp"
#include "step/stages.hpp"

namespace perimpm {

template <class Real>
Vec3 affine_spin(const World<Real>& w, std::size_t p) {
    constexpr double kMoment[] = {0, kCarriedMoment<1>, kCarriedMoment<2>, kCarriedMoment<3>};
    const auto C = [&](int r, int c) { return static_cast<double>(w.C[3 * r + c][p]); };
    return static_cast<double>(w.mass[p]) * kMoment[w.transfer_needs.order] * w.spacing() * w.spacing() *
           Vec3(C(2, 1) - C(1, 2), C(0, 2) - C(2, 0), C(1, 0) - C(0, 1));
}

template <class Real>
Ledger take_ledger(World<Real>& w) {
    Ledger l{};
    l.time = w.time;
    Vec3 momentum = Vec3::Zero(), spin = Vec3::Zero();
    for (std::size_t p = 0; p < w.count; ++p) {
        const Vec3 x(static_cast<double>(w.x[0][p]), static_cast<double>(w.x[1][p]), static_cast<double>(w.x[2][p]));
        const Vec3 v(static_cast<double>(w.v[0][p]), static_cast<double>(w.v[1][p]), static_cast<double>(w.v[2][p]));
        const double m = static_cast<double>(w.mass[p]);
        l.kinetic += 0.5 * m * v.squaredNorm();
        l.potential -= m * w.scene.simulation.gravity.dot(x);
        momentum += m * v;
        spin += m * x.cross(v);
        if (w.transfer_needs.affine) spin += affine_spin(w, p);
    }
    for (int c = 0; c < 3; ++c) l.momentum[c] = momentum[c], l.angular_momentum[c] = spin[c];
    for (Material<Real>& m : w.materials) {
        if (m.has_bonds()) {
            pack_positions(w, m);
            if (m.needs.prepare) for_each_chunk(w, m, [&](std::size_t, Block<Real>& b) { m.law->prepare(b); });
        }
        l.elastic = reduce_chunks(
            w, m, l.elastic, [&](Block<Real>& b) { return m.law->energy(b); },
            [](double a, double b) { return a + b; });
    }
    if (w.has_crack_surfaces) l.elastic += contact_energy(w);
    return l;
}

template Vec3 affine_spin(const World<float>&, std::size_t);
template Vec3 affine_spin(const World<double>&, std::size_t);
template Ledger take_ledger(World<float>&);
template Ledger take_ledger(World<double>&);

}  // namespace perimpm
