// The images of a survey and the matches of their pairs: the first half of match_ties.
#pragma once

#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "adjustment/evidence_pairs.hpp"
#include "adjustment/guided_pairing.hpp"
#include "adjustment/image_features.hpp"
#include "adjustment/tie_matches.hpp"

namespace cairn::adjustment {

using IndexPair = std::pair<std::size_t, std::size_t>;  // indices into survey.frames, first < second

// What is kept of an image: its features as pixels of the frame's camera and as rays.
struct ImageView {
  const survey::Camera* camera = nullptr;
  bool usable = false;
  ImageFeatures features;            // ranked
  std::vector<geometry::Vec2> rays;  // on the plane z = 1
  std::optional<base::Reject> reject;
};

struct ImagePair {
  IndexPair frames;
  std::vector<FeaturePair> consistent;
  TiePair report;
};

class PairMatcher {
 public:
  // Keeps references: the survey and the options must outlive it.
  PairMatcher(const survey::Survey& rough, const TieMatchOptions& options, base::RunContext& ctx);

  // Reads every image once, in parallel; failures become the views' rejects.
  void find_features(const ImageLoader& load);
  // By descriptors alone, the strongest features. Each pair is tried once, however often it is asked for.
  void match(std::vector<IndexPair> pairs);
  // Again with all features where the poses say; a pair's matches are replaced where more are found.
  void match_guided(const std::vector<IndexPair>& pairs, const std::vector<GuidedView>& views);

  [[nodiscard]] const ImageView& view(std::size_t i) const { return views_[i]; }
  [[nodiscard]] const std::vector<ImagePair>& matched() const { return matched_; }  // ascending
  // Of the pairs that agree, by the rough poses.
  [[nodiscard]] PairEvidence evidence() const;

 private:
  [[nodiscard]] ImagePair verified(const IndexPair& frames, const std::vector<FeaturePair>& paired) const;

  const survey::Survey& rough_;
  const TieMatchOptions& options_;
  base::RunContext& ctx_;
  std::vector<ImageView> views_;
  std::set<IndexPair> tried_;
  std::vector<ImagePair> matched_;
};

// Share of a's view of level ground at `ground_up` [local up, m] that b, its image widened by slack_m of ground, sees
// too; 1 where it cannot be said.
[[nodiscard]] double shared_view(const survey::Frame& a, const survey::Camera& camera_a, const survey::Frame& b,
                                 const survey::Camera& camera_b, double ground_up, double slack_m);

}  // namespace cairn::adjustment
