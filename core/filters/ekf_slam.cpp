#include "core/filters/ekf_slam.h"

namespace credence {

using namespace internal;

template class EkfSlam<PlanarModel>;
template class EkfSlam<MonobotModel>;

}  // namespace credence
