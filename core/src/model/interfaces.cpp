// The interfaces' virtual tables and type information live here, once, so that every plugin shares them.
#include <stdexcept>

#include "perimpm/model/constitutive_law.hpp"
#include "perimpm/model/fracture_criterion.hpp"
#include "perimpm/model/transfer_kernel.hpp"

namespace perimpm {

template <class Real>
ConstitutiveLaw<Real>::~ConstitutiveLaw() = default;

template <class Real>
StableStep ConstitutiveLaw<Real>::stable_step(const Block<Real>&) const {
    return {};
}

template <class Real>
void ConstitutiveLaw<Real>::bond_energy(const Block<Real>&) const {
    throw std::logic_error("this law does not declare stores_in_bonds: it has no energy per bond");
}

template <class Real>
TransferKernel<Real>::~TransferKernel() = default;

template <class Real>
ParticleIntegrator<Real>::~ParticleIntegrator() = default;

template <class Real>
FractureCriterion<Real>::~FractureCriterion() = default;

template <class Real>
void FractureCriterion<Real>::decide(const Block<Real>&, std::span<const BondCandidate> found,
                                     std::vector<BondCandidate>& cuts) const {
    cuts.assign(found.begin(), found.end());
}

template class ConstitutiveLaw<float>;
template class ConstitutiveLaw<double>;
template class TransferKernel<float>;
template class TransferKernel<double>;
template class ParticleIntegrator<float>;
template class ParticleIntegrator<double>;
template class FractureCriterion<float>;
template class FractureCriterion<double>;

}  // namespace perimpm
