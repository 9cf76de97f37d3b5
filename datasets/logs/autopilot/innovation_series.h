#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "datasets/logs/bytes/byte_cursor.h"
#include "datasets/logs/log_sink.h"

namespace credence::internal {

/// The number of an estimator that a log says, 0 to 255. Throws DataError at `message` for any other.
int estimator_number(double said, const ByteCursor& message);

/// Innovations of sensors that do not speak at the same times, with variances and no covariances.
///
/// Every sensor has its own course: step k of the run that is made of them holds the k-th innovation of each,
/// so that neighbours in time are neighbours of the same sensor.
class InnovationSeries {
 public:
  /// A sensor's row as the log has it.
  enum class Row {
    taken,
    repeated,  ///< the same innovation as in the row before: the topic only says it again
    silent,    ///< a variance that is not positive and finite: the sensor is not in use
  };

  /// The number, from 0, of the sensor of this name, which is declared where it is new.
  std::size_t sensor(const std::string& name, Index dim, bool angle);

  /// said: what the log holds of the row, by which a repeat is known; empty: ν itself.
  Row add(std::size_t sensor, double time_s, std::span<const double> nu, std::span<const double> variances,
          std::span<const double> said = {});

  /// The same of a sensor of one dimension of which NIS alone is known.
  std::size_t nis_sensor(const std::string& name);
  Row add_nis(std::size_t sensor, double time_s, double nis);

  /// Whether any sensor said anything.
  bool empty() const;

  /// One run of all sensors that said anything.
  void emit(LogSink& sink) const;

  /// "49 of gps_hpos at 4.9 Hz, …"
  std::string counts() const;
  /// Sensors with enough rows and a new value in every one: the log may leave values out.
  std::string never_repeated() const;
  bool any_vector() const;  ///< a sensor of more than one dimension

 private:
  struct SensorSeries {
    std::string name;
    Index dim = 1;
    bool angle = false, nis_alone = false;
    std::vector<double> nu{}, variances{};  ///< one after another
    std::vector<double> last_said{};
    std::int64_t repeated = 0;
    double first_s = 0.0, last_s = 0.0;

    std::int64_t count() const { return std::ssize(nu) / dim; }
    /// One value that is repeated for ever is what the topic holds before the sensor speaks.
    bool in_use() const { return count() > (repeated > 0 ? 1 : 0); }
  };

  std::vector<SensorSeries> sensors_;
};

}  // namespace credence::internal
