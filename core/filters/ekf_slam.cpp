#include "core/filters/ekf_slam.h"

namespace credence {

template class EkfSlam<PlanarModel>;
template class EkfSlam<MonobotModel>;

}  // namespace credence
