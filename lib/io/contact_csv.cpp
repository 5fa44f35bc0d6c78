#include "io/contact_csv.hpp"

#include <set>
#include <tuple>

#include "base/atomic_file.hpp"
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
    auto& v = row.vertex;
    v.pad = csv.integer(pad);
    v.order = csv.integer(order);
    v.position = {csv.real(x), csv.real(y), csv.real(z)};
    const auto word = csv.text(status);
    if (word != "observed" && word != "inferred")
      throw csv.error(status, "unknown contact status").allowed("observed, inferred");
    v.observed = word == "observed";
    v.sigma_m = csv.optional_real(sigma).value_or(0.0);
    if (v.sigma_m < 0.0) throw csv.error(sigma, "sigma is negative").allowed("0 or more");
    v.closed = csv.integer(closed, 0, 1) == 1;
    if (!seen.emplace(row.rock_id, v.pad, v.order).second)
      throw csv.error(order, "this place in the contact line is taken already").hint("Number the points of a pad");
    file.rows.push_back(row);
  }
  return file;
}

void write_contact_csv(const std::filesystem::path& path, const ContactFile& file) {
  std::string text = "# crs: " + (file.crs.empty() ? std::string("local") : file.crs) +
                     "\nrock_id,pad_id,order,x,y,z,status,sigma_m,closed\n";
  for (const auto& [rock_id, v] : file.rows) {
    text += std::to_string(rock_id) + ',' + std::to_string(v.pad) + ',' + std::to_string(v.order);
    for (int axis = 0; axis < 3; ++axis) text += ',' + base::to_text(v.position[axis]);
    text += v.observed ? ",observed," : ",inferred,";
    text += base::to_text(v.sigma_m) + (v.closed ? ",1\n" : ",0\n");
  }
  base::write_file(path, text);
}

}  // namespace cairn::io
