#pragma once

#include <memory>

#include "step/stages.hpp"
#include "support/box_scene.hpp"
#include "support/scene.hpp"

/// The world of kBox with overrides, as a simulation has it before its first step.
template <class Real = double>
std::unique_ptr<perimpm::World<Real>> box_world(const Overrides& overrides = {}, int threads = 2) {
    auto world = std::make_unique<perimpm::World<Real>>(scene_from(kBox, overrides), threads);
    perimpm::build_world(*world);
    return world;
}

template <class Real>
perimpm::Vec3 at(const perimpm::FieldArray<Real>& field, std::size_t i) {
    return {static_cast<double>(field[0][i]), static_cast<double>(field[1][i]), static_cast<double>(field[2][i])};
}

/// Sums of the grid's nodes: momentum (or velocity) and mass.
template <class Real>
Eigen::Vector4d node_sums(perimpm::World<Real>& w) {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (std::size_t g = 0; g < w.grid.size(); ++g)
        for (std::size_t k = 0; k < perimpm::kBlockValues; ++k)
            sum[static_cast<int>(k % 4)] += static_cast<double>(w.grid.nodes(g)[k]);
    return sum;
}
