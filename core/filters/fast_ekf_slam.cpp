#include "core/filters/fast_ekf_slam.h"

namespace credence {

template class FastEkfSlam<PlanarModel>;
template class FastEkfSlam<MonobotModel>;

}  // namespace credence
