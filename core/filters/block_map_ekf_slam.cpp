#include "core/filters/block_map_ekf_slam.h"

namespace credence {

using namespace internal;

template class BlockMapEkfSlam<PlanarModel>;
template class BlockMapEkfSlam<MonobotModel>;

}  // namespace credence
