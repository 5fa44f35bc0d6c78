#include "io/contact_csv.hpp"

#include <set>
#include <tuple>

#include "base/number_text.hpp"
#include "io/csv.hpp"

namespace cairn::io {

ContactFile read_contact_csv(const std::filesystem::path& path) {
  CsvReader csv(path);
  ContactFile file;
  for (const auto& comment : csv.comments())
    if (comment.rfind("crs:", 0) == 0) file.crs = base::trim(std::string_view(comment).substr(4));
  const auto rock = csv.column("rock_id"), pad = csv.column("pad_id"), order = csv.column("order"), x = csv.column("x"),
             y = csv.column("y"), z = csv.column("z"), status = csv.column("status"), sigma = csv.column("sigma_m"),
             closed = csv.column("closed");
  std::set<std::tuple<std::int64_t, std::int64_t, std::int64_t>> seen;
  while (csv.next()) {
    ContactRow row;
    row.rock_id = csv.integer(rock);
    row.pad_id = csv.integer(pad);
    row.order = csv.integer(order);
    row.position = {csv.real(x), csv.real(y), csv.real(z)};
    const auto word = csv.text(status);
    if (word != "observed" && word != "inferred")
      throw csv.error(status, "unknown contact status").allowed("observed, inferred");
    row.observed = word == "observed";
    row.sigma_m = csv.optional_real(sigma).value_or(0.0);
    if (row.sigma_m < 0.0) throw csv.error(sigma, "sigma is negative").allowed("0 or more");
    row.closed = csv.integer(closed, 0, 1) == 1;
    if (!seen.emplace(row.rock_id, row.pad_id, row.order).second)
      throw csv.error(order, "this place in the contact line is taken already").hint("Number the points of a pad");
    file.rows.push_back(row);
  }
  return file;
}

}  // namespace cairn::io
