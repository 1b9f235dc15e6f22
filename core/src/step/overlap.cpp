#include <fmt/format.h>

#include <algorithm>

#include "step/stages.hpp"

namespace perimpm {

template <class Real>
std::vector<std::string> starting_overlaps(const World<Real>& w) {
    std::vector<std::string> messages;
    for (const Collider& collider : w.colliders) {
        std::vector<std::size_t> inside(w.scene.bodies.size(), 0);
        for (std::size_t p = 0; p < w.count; ++p) {
            const Vec3 x(static_cast<double>(w.x[0][p]), static_cast<double>(w.x[1][p]),
                         static_cast<double>(w.x[2][p]));
            if (collider.signed_distance(x) >= 0) continue;
            const auto next = std::upper_bound(w.body_begin.begin(), w.body_begin.end(), w.id[p]);
            ++inside[static_cast<std::size_t>(next - w.body_begin.begin()) - 1];
        }
        for (std::size_t b = 0; b < inside.size(); ++b)
            if (inside[b] > 0)
                messages.push_back(fmt::format(
                    "{} of {} particles of body '{}' start inside collider '{}', where they are held or "
                    "squeezed out: move the body or the collider",
                    inside[b], w.body_begin[b + 1] - w.body_begin[b], w.scene.bodies[b].name, collider.name()));
    }
    return messages;
}

template std::vector<std::string> starting_overlaps(const World<float>&);
template std::vector<std::string> starting_overlaps(const World<double>&);

}  // namespace perimpm
