// Tracking scores: CLEAR MOT, identity, HOTA.
#pragma once

#include <array>
#include <cstddef>

#include "evaluation/tracking_sequence.hpp"

namespace cairn::evaluation {

// CLEAR MOT (Bernardin & Stiefelhagen 2008) with the matching of the MOTChallenge kit and TrackEval: in each frame a
// pair that was matched in the frame before stays matched while its IoU allows; the rest is assigned for the greatest
// summed IoU. A switch is a matched identity other than the one last matched, however long ago.
struct ClearScore {
  std::size_t truths = 0, tp = 0, fp = 0, fn = 0, id_switches = 0;
  std::size_t objects = 0;         // identities in truth
  std::size_t mostly_tracked = 0;  // matched in more than 80 % of their frames
  std::size_t mostly_lost = 0;     // in less than 20 %
  std::size_t fragmentations = 0;  // times that tracking of an identity resumed
  double overlap_sum = 0.0;        // of the IoU of matched pairs

  [[nodiscard]] double mota() const;  // 1 - (fp + fn + switches) / truths; may be negative; 0 without truth
  [[nodiscard]] double motp() const;  // mean IoU of matched pairs, 0..1 (greater is better)
  [[nodiscard]] double precision() const;
  [[nodiscard]] double recall() const;
};
[[nodiscard]] ClearScore clear_score(const Sequence& sequence, double iou_threshold = 0.5);

// Identity (Ristani et al. 2016): identities of truth and tracks are assigned one to one over the whole sequence so
// that idfp + idfn is least.
struct IdentityScore {
  std::size_t idtp = 0, idfp = 0, idfn = 0;

  [[nodiscard]] double idf1() const;
  [[nodiscard]] double precision() const;
  [[nodiscard]] double recall() const;
};
[[nodiscard]] IdentityScore identity_score(const Sequence& sequence, double iou_threshold = 0.5);

// HOTA (Luiten et al. 2021): at each alpha of .05, .10 .. .95, DetA = TP/(TP+FN+FP), AssA = mean over TP of
// TPA/(TPA+FNA+FPA), HOTA = sqrt(DetA AssA), LocA = mean IoU of TP. Figures are means over alpha.
struct HotaScore {
  static constexpr std::size_t kAlphas = 19;
  struct AtAlpha {
    std::size_t tp = 0, fp = 0, fn = 0;
    double ass_a = 0.0, ass_re = 0.0, ass_pr = 0.0, loc_a = 0.0;
    [[nodiscard]] double det_a() const;
    [[nodiscard]] double hota() const;
  };
  std::array<AtAlpha, kAlphas> alphas;

  [[nodiscard]] double hota() const;
  [[nodiscard]] double det_a() const;
  [[nodiscard]] double ass_a() const;
  [[nodiscard]] double loc_a() const;
};
[[nodiscard]] HotaScore hota_score(const Sequence& sequence);

// Several sequences as one, as TrackEval combines them: counts are added, association and localisation weighted by TP.
void add(ClearScore& sum, const ClearScore& score);
void add(IdentityScore& sum, const IdentityScore& score);
void add(HotaScore& sum, const HotaScore& score);

}  // namespace cairn::evaluation
