#include "analysis/evidence/sums/evidence_bytes.h"

#include <bit>
#include <concepts>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "montecarlo/engine/byte_stream.h"

namespace credence::internal {
namespace {

/// To be raised with everything that changes what is kept.
constexpr std::uint32_t kFormat = 25;

template <class T>
concept HeldPlainly = std::is_arithmetic_v<T> || std::is_enum_v<T> || std::same_as<T, Moments> ||
    std::same_as<T, SkewedMoments> || std::same_as<T, CoverageCount> || std::same_as<T, StepSums> ||
    std::same_as<T, ScoreMoments> || std::same_as<T, WholeTurns> || std::same_as<T, CourseOfRun>;

/// Writes or reads values, one description of each type for both.
template <class Bytes>
class Pass {
 public:
  static constexpr bool kReads = std::same_as<Bytes, ByteReader>;

  explicit Pass(Bytes& bytes) : bytes_(bytes) {}

  template <class... T>
  void operator()(T&... values) {
    (one(values), ...);
  }

  /// What was read cannot be.
  void require(bool fits) const {
    if constexpr (kReads) {
      if (!fits) bytes_.refuse("does not fit together");
    }
  }

 private:
  template <class T>
  using Held = std::conditional_t<kReads, T, const T>;

  template <class T>
  requires HeldPlainly<std::remove_const_t<T>>
  void one(T& value) {
    if constexpr (kReads) {
      bytes_.get(value);
      if constexpr (std::same_as<T, CoverageCount>) require(value.inside >= 0 && value.inside <= value.total);
    } else {
      bytes_.put(value);
    }
  }

  void one(Held<std::string>& text) {
    if constexpr (kReads) {
      bytes_.get(text);
    } else {
      bytes_.put(std::string_view(text));
    }
  }

  /// How many follow, of so many bytes at least.
  std::size_t count(std::size_t here, std::size_t item_size = 1) {
    if constexpr (kReads) {
      return bytes_.get_count(item_size);
    } else {
      bytes_.put(static_cast<std::uint64_t>(here));
      return here;
    }
  }

  void one(Held<std::vector<bool>>& values) {
    const std::size_t size = count(values.size());
    if constexpr (kReads) values.resize(size);
    for (std::size_t i = 0; i < size; ++i) {
      bool value = values[i];
      one(value);
      if constexpr (kReads) values[i] = value;
    }
  }

  template <class T>
  void one(std::vector<T>& values) {
    each(values);
  }
  template <class T>
  void one(const std::vector<T>& values) {
    each(values);
  }
  template <class Values>
  void each(Values& values) {
    const std::size_t size = count(values.size());
    if constexpr (kReads) {
      bytes_.reserve(values, size);
      for (std::size_t i = 0; i < size; ++i) one(values.emplace_back());
    } else {
      for (auto& value : values) one(value);
    }
  }

  template <class K, class V>
  void one(std::map<K, V>& values) {
    const std::size_t size = count(0);
    for (std::size_t i = 0; i < size; ++i) {
      K key{};
      one(key);
      one(values[key]);
    }
  }
  template <class K, class V>
  void one(const std::map<K, V>& values) {
    count(values.size());
    for (const auto& [key, value] : values) (*this)(key, value);
  }

  void one(Held<Vector>& v) {
    const std::size_t size = count(static_cast<std::size_t>(v.size()), sizeof(double));
    if constexpr (kReads) v.resize(static_cast<Index>(size));
    for (Index i = 0; i < v.size(); ++i) one(v[i]);
  }

  void one(Held<Matrix>& M) {
    const std::size_t rows = count(static_cast<std::size_t>(M.rows()));
    const std::size_t columns = count(static_cast<std::size_t>(M.cols()));
    if constexpr (kReads) {
      require(rows == 0 || columns == 0 || rows * columns <= bytes_.left() / sizeof(double));
      M.resize(static_cast<Index>(rows), static_cast<Index>(columns));
    }
    for (Index i = 0; i < M.size(); ++i) one(M.data()[i]);
  }

  void one(Held<VectorMoments>& moments) {
    (*this)(moments.count, moments.mean, moments.scatter);
    require(moments.count >= 0 && moments.scatter.rows() == moments.mean.size() &&
            moments.scatter.cols() == moments.mean.size());
  }

  void one(Held<UniformHistogram>& histogram) {
    std::vector<std::int64_t> counts = histogram.counts();
    std::int64_t invalid = histogram.invalid();
    const std::size_t bins = counts.size();
    (*this)(counts, invalid);
    require(counts.size() == bins);
    if constexpr (kReads) histogram = UniformHistogram(counts, invalid);
  }

  void one(Held<LagProducts>& lags) {
    std::vector<Matrix> products;
    std::vector<std::int64_t> pairs;
    for (Index lag = 0; lag <= lags.lags(); ++lag) {
      products.push_back(lags.product(lag));
      pairs.push_back(lags.pairs(lag));
    }
    std::int64_t invalid = lags.invalid();
    const Index dim = lags.dim(), most = lags.lags();
    (*this)(products, pairs, invalid);
    if constexpr (kReads) lags = LagProducts(products, pairs, invalid);
    require(lags.dim() == dim && lags.lags() == most);
  }

  void one(Held<LongLags>& lags) {
    LongLags::Levels levels = lags.levels();
    for (LagProducts& level : levels) one(level);
    if constexpr (kReads) lags = LongLags(std::move(levels));
  }

  void one(Held<SecondMoments>& moments) {
    if constexpr (kReads) {
      Index dim = 0;
      std::vector<SkewedMoments> along;
      (*this)(dim, along);
      moments = SecondMoments(dim, std::move(along));
    } else {
      const Index dim = moments.dim();
      (*this)(dim, moments.along());
    }
  }

  void one(Held<RunAverages>& averages) { (*this)(averages.moments, averages.first, averages.least_dof); }

  void one(Held<StudyStatistics>& statistics) {
    if constexpr (kReads) {
      statistics = statistics_from_bytes(bytes_.get_bytes());
    } else {
      bytes_.put(std::span<const std::byte>(to_bytes(statistics)));
    }
  }

  void one(Held<Block>& block) { (*this)(block.name, block.part, block.states); }

  void one(Held<Sensor>& sensor) {
    (*this)(sensor.name, sensor.dim, sensor.piece, sensor.variances, sensor.angles, sensor.nis_alone,
            sensor.variances_alone);
  }

  void one(Held<RunLayout>& layout) {
    (*this)(layout.states, layout.angles, layout.units, layout.blocks, layout.sensors, layout.landmark_dim,
            layout.has_truth, layout.joint_covariance, layout.nonlinear, layout.inflated,
            layout.componentwise);
  }

  void one(Held<BlockSums>& block) {
    (*this)(block.name, block.part, block.nees, block.runs, block.few, block.squared_error, block.claimed);
  }

  void one(Held<CoarseSeries>& series) {
    std::vector<double> averages = series.averages();
    std::int64_t rows = series.rows_per_value();
    (*this)(averages, rows);
    if constexpr (kReads) series = CoarseSeries(std::move(averages), rows);
  }

  /// The sensor is known.
  void one(Held<SensorSums>& s) {
    (*this)(s.varies, s.nis, s.by_dimension, s.fit, s.far_tail, s.largest_nis, s.ties, s.lags, s.run_means,
            s.first, s.scalar_lags, s.scalar_run_means, s.values, s.scalar_values, s.components, s.pairs,
            s.measurement_share, s.changes.bins, s.unwrapped, s.turns);
    require(s.changes.bins.empty() || s.changes.bins.size() == ChangesByNis::kBins);
  }

  void one(Held<std::vector<SensorSums>>& sensors) {
    const std::size_t size = count(sensors.size());
    for (std::size_t i = 0; i < size; ++i) {
      if constexpr (kReads) {
        Sensor sensor;
        one(sensor);
        require(sensor.piece >= 1);
        one(sensors.emplace_back(std::move(sensor)));
      } else {
        (*this)(sensors[i].sensor, sensors[i]);
      }
    }
  }

  void one(Held<SensorPairSums>& pair) { (*this)(pair.first, pair.second, pair.first_dim, pair.both); }

  void one(Held<CoverageSums>& coverage) {
    for (auto& region : coverage.regions) {
      (*this)(region.count, region.expected);
      require(region.count.size() == region.expected.size());
    }
  }

  void one(Held<RunSums>& runs) {
    (*this)(runs.nees_values, runs.nees, runs.samples, runs.log_variances, runs.last_error,
            runs.last_covariance, runs.last_whitened, runs.failed);
    require(runs.samples.size() == runs.log_variances.size());
    for (std::size_t i = 0; i < runs.samples.size(); ++i)
      require(runs.samples[i].cols() == runs.log_variances[i].size());
    require(runs.last_error.size() == runs.last_covariance.size());
    for (std::size_t i = 0; i < runs.last_error.size(); ++i) {
      const Matrix& P = runs.last_covariance[i];
      require(P.rows() == runs.last_error[i].size() && P.cols() == P.rows());
    }
  }

  void one(Held<StretchSums>& stretches) {
    (*this)(stretches.runs, stretches.square, stretches.means, stretches.oscillating, stretches.samples,
            stretches.across, stretches.between);
    const Index dim = stretches.square.rows();
    for (const Matrix* sum : {&stretches.square, &stretches.across, &stretches.between})
      require(sum->rows() == dim && sum->cols() == dim);
    require(stretches.runs >= 0 && (stretches.runs == 0 || stretches.means.mean.size() == dim));
  }

  void one(Held<TailSums>& tails) { (*this)(tails.weights, tails.heavier); }

  void one(Held<StretchMoments>& stretches) {
    for (auto& moments : stretches.of) one(moments);
  }

  void one(Held<LawSums>& law) {
    (*this)(law.averaged, law.second_moments, law.error_means, law.correlated, law.whitened_means,
            law.stretches, law.stretch_moments, law.whitened, law.nees_tails, law.nis_tails, law.nis_of_runs,
            law.nis_at);
  }

  void one(Held<LatenessSums>& lateness) {
    (*this)(lateness.runs, lateness.run_slopes, lateness.stretch_slopes);
  }

  void one(Held<ScoreSums>& scores) { (*this)(scores.log, scores.energy, scores.of_position); }

  void one(Held<CountedRows>& rows) { (*this)(rows.count, rows.first); }

  void one(Held<Evidence>& e) {
    (*this)(e.layout, e.study, e.blocks, e.sensors, e.coverage, e.whole_runs, e.law, e.lateness, e.scores,
            e.sensor_pairs, e.clean_nees, e.clean_nis, e.nees_outliers, e.nis_outliers, e.turns,
            e.narrow_angles, e.rows, e.step_stride, e.rejected, e.wrongly_certain, e.first_run, e.state_dim,
            e.joint_covariance, e.has_truth);
    constexpr std::int64_t kMostStride = std::int64_t{1} << 40;
    for (const CourseOfRun& failed : e.whole_runs.failed)
      require(failed.run >= 0 && failed.run < e.study.runs && failed.course.rows > 0);
    require(e.step_stride >= 1 && e.step_stride <= kMostStride &&
            std::has_single_bit(static_cast<std::uint64_t>(e.step_stride)));
  }

  Bytes& bytes_;
};

}  // namespace

std::vector<std::byte> to_bytes(const Evidence& evidence) {
  ByteWriter writer;
  Pass<ByteWriter> pass(writer);
  pass(kFormat, evidence);
  return writer.take();
}

Evidence evidence_from_bytes(std::span<const std::byte> bytes, const RunLayout& layout) {
  ByteReader reader(bytes, "the evidence of a chunk");
  Pass<ByteReader> pass(reader);
  std::uint32_t format = 0;
  Evidence evidence;
  try {
    pass(format);
    if (format != kFormat) reader.refuse("is of another version");
    pass(evidence);
  } catch (const std::invalid_argument& error) {
    reader.refuse(error.what());
  }
  reader.require_end();
  if (evidence.layout != layout) reader.refuse("is of another layout");
  return evidence;
}

}  // namespace credence::internal
