// survey.json to and from the manifest; the fields shared with other JSON files of a survey.
#pragma once

#include <string_view>

#include "io/json.hpp"
#include "survey/manifest.hpp"

namespace cairn::io {

inline constexpr int kSurveySchemaVersion = 1;

[[nodiscard]] Json to_json(const survey::Manifest& manifest);
// `name` stands for the file in messages. Throws invalid_input, or crs_mismatch for a position off the globe.
[[nodiscard]] survey::Manifest manifest_from_json(const Json& json, std::string_view name);

[[nodiscard]] Json to_json(const survey::Camera& camera);
[[nodiscard]] survey::Camera camera_from_json(const Json& json);

[[nodiscard]] Json to_json(const geometry::Similarity& similarity);
// {scale, rotation (3x3) or quaternion {qw,qx,qy,qz}, translation_m}. The rotation is taken as written
// where it is orthonormal within 1e-6; beyond that invalid_input.
[[nodiscard]] geometry::Similarity similarity_from_json(const Json& json);

// Origin with its height type.
[[nodiscard]] Json to_json(const survey::Origin& origin);
[[nodiscard]] survey::Origin origin_from_json(const Json& json);

// The member `frame` of every result file: the origin whose local ENU the numbers are in.
// require_same_frame throws crs_mismatch where two files are in different frames.
void require_same_frame(const survey::Origin& found, const survey::Origin& expected, std::string_view name);

}  // namespace cairn::io
