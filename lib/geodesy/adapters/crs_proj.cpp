#include "geodesy/crs.hpp"

#include <proj.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>
#include <utility>

#include "base/error.hpp"
#include "base/number_text.hpp"

namespace cairn::geodesy {
namespace {

using base::Error;
using base::ErrorCode;
using geometry::Geodetic;
using geometry::Vec3;

constexpr double kTwoPi = 6.283185307179586;

struct FreeContext {
  void operator()(PJ_CONTEXT* c) const { proj_context_destroy(c); }
};
struct FreePj {
  void operator()(PJ* p) const { proj_destroy(p); }
};
struct FreeList {
  void operator()(PJ_OBJ_LIST* l) const { proj_list_destroy(l); }
};
struct FreeOperationContext {
  void operator()(PJ_OPERATION_FACTORY_CONTEXT* c) const { proj_operation_factory_context_destroy(c); }
};
using Context = std::unique_ptr<PJ_CONTEXT, FreeContext>;
using Pj = std::unique_ptr<PJ, FreePj>;

void ignore_log(void*, int, const char*) {}

Context make_context() {
  Context context(proj_context_create());
  if (!context) throw Error(ErrorCode::internal, "PROJ could not be started");
  proj_log_func(context.get(), nullptr, ignore_log);
  proj_context_set_enable_network(context.get(), 0);
  return context;
}

std::string shortened(const std::string& text) {
  constexpr std::size_t kShown = 120;
  return text.size() <= kShown ? text : text.substr(0, kShown) + "...";
}

Error mismatch(std::string message, const std::string& crs) {
  return Error(ErrorCode::crs_mismatch, std::move(message)).found("'" + shortened(crs) + "'");
}

Pj parse(PJ_CONTEXT* context, const std::string& crs) {
  constexpr std::size_t kMaxText = 1U << 20U;
  Pj pj;
  if (!crs.empty() && crs.size() <= kMaxText && crs.find('\0') == std::string::npos)
    pj.reset(proj_create(context, crs.c_str()));
  if (!pj || proj_is_crs(pj.get()) == 0)
    throw mismatch("text that is not a coordinate reference system", crs)
        .allowed("EPSG:n, EPSG:n+m, WKT 1 or 2, a PROJ string with +type=crs");
  return pj;
}

// Without the transformation to WGS84 that WKT 1 may bring along.
Pj unbound(PJ_CONTEXT* context, Pj crs) {
  while (crs && proj_get_type(crs.get()) == PJ_TYPE_BOUND_CRS) crs.reset(proj_get_source_crs(context, crs.get()));
  return crs;
}

struct Axis {
  std::string direction;
  double factor = 1.0;
};

std::vector<Axis> axes_of(PJ_CONTEXT* context, const PJ* crs) {
  std::vector<Axis> axes;
  const Pj system(proj_crs_get_coordinate_system(context, crs));
  if (!system) return axes;
  const int count = proj_cs_get_axis_count(context, system.get());
  for (int i = 0; i < count; ++i) {
    const char* direction = nullptr;
    double factor = 1.0;
    if (proj_cs_get_axis_info(context, system.get(), i, nullptr, nullptr, &direction, &factor, nullptr, nullptr,
                              nullptr) == 0)
      return {};
    axes.push_back({direction != nullptr ? direction : "", factor});
  }
  return axes;
}

std::string code_of(const PJ* crs) {
  const char* authority = proj_get_id_auth_name(crs, 0);
  const char* code = proj_get_id_code(crs, 0);
  return authority != nullptr && code != nullptr ? std::string(authority) + ":" + code : std::string();
}

bool is_geographic(PJ_TYPE type) {
  return type == PJ_TYPE_GEOGRAPHIC_2D_CRS || type == PJ_TYPE_GEOGRAPHIC_3D_CRS;
}

void set_vertical(CrsInfo& info, const Axis& axis) {
  info.has_vertical = true;
  info.vertical_unit_m = axis.factor;
  info.vertical_is_depth = axis.direction == "down";
}

CrsInfo describe(PJ_CONTEXT* context, const PJ* given, const std::string& text) {
  CrsInfo info;
  const char* name = proj_get_name(given);
  info.name = name != nullptr ? name : "";
  info.authority_code = code_of(given);
  Pj crs = unbound(context, Pj(proj_clone(context, given)));
  if (crs && proj_get_type(crs.get()) == PJ_TYPE_COMPOUND_CRS) {
    const Pj vertical = unbound(context, Pj(proj_crs_get_sub_crs(context, crs.get(), 1)));
    Pj horizontal = unbound(context, Pj(proj_crs_get_sub_crs(context, crs.get(), 0)));
    const auto axes = vertical ? axes_of(context, vertical.get()) : std::vector<Axis>();
    if (!horizontal || axes.size() != 1) throw mismatch("a compound CRS whose parts cannot be told apart", text);
    set_vertical(info, axes[0]);
    if (info.authority_code.empty()) {
      const std::string h = code_of(horizontal.get());
      const std::string v = code_of(vertical.get());
      if (h.rfind("EPSG:", 0) == 0 && v.rfind("EPSG:", 0) == 0) info.authority_code = h + "+" + v.substr(5);
    }
    crs = std::move(horizontal);
  }
  const PJ_TYPE type = crs ? proj_get_type(crs.get()) : PJ_TYPE_UNKNOWN;
  if (!is_geographic(type) && type != PJ_TYPE_PROJECTED_CRS && type != PJ_TYPE_GEOCENTRIC_CRS)
    throw mismatch("a CRS that does not place points on the Earth", text)
        .allowed("geographic, projected, geocentric or compound")
        .hint("Give the horizontal CRS too, such as EPSG:32615+5773");
  info.geographic = is_geographic(type);
  const auto axes = axes_of(context, crs.get());
  if (axes.size() < 2 || !(axes[0].factor > 0.0)) throw mismatch("a CRS without two usable axes", text);
  info.horizontal_unit_m = axes[0].factor;
  if (axes.size() > 2) set_vertical(info, axes[2]);
  return info;
}

struct Operation {
  Pj pj;
  std::string text;
};

std::vector<std::string> missing_grids(PJ_CONTEXT* context, const PJ* operation) {
  std::vector<std::string> missing;
  const int grids = proj_coordoperation_get_grid_used_count(context, operation);
  for (int i = 0; i < grids; ++i) {
    const char* name = nullptr;
    int available = 0;
    if (proj_coordoperation_get_grid_used(context, operation, i, &name, nullptr, nullptr, nullptr, nullptr, nullptr,
                                          &available) != 0 &&
        available == 0)
      missing.emplace_back(name != nullptr ? name : "?");
  }
  return missing;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const auto& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::string describe_operation(PJ_CONTEXT* context, const PJ* operation) {
  const char* description = proj_pj_info(const_cast<PJ*>(operation)).description;
  std::string text = description != nullptr ? description : "unnamed operation";
  const double accuracy = proj_coordoperation_get_accuracy(context, operation);
  if (accuracy >= 0.0) text += "; accuracy " + base::to_text(accuracy) + " m";
  const int grids = proj_coordoperation_get_grid_used_count(context, operation);
  for (int i = 0; i < grids; ++i) {
    const char* name = nullptr;
    if (proj_coordoperation_get_grid_used(context, operation, i, &name, nullptr, nullptr, nullptr, nullptr, nullptr,
                                          nullptr) != 0 &&
        name != nullptr)
      text += std::string("; grid ") + name;
  }
  return text;
}

Operation best_operation(PJ_CONTEXT* context, const PJ* source, const PJ* target, const Geodetic& place,
                         const std::string& crs, bool accept_coarser) {
  const std::unique_ptr<PJ_OPERATION_FACTORY_CONTEXT, FreeOperationContext> factory(
      proj_create_operation_factory_context(context, nullptr));
  if (!factory) throw Error(ErrorCode::internal, "PROJ could not list operations");
  constexpr double kHalfDegree = 0.05;  // about 5 km: the survey's surroundings
  proj_operation_factory_context_set_area_of_interest(
      context, factory.get(), std::max(-180.0, place.longitude_deg - kHalfDegree),
      std::max(-90.0, place.latitude_deg - kHalfDegree), std::min(180.0, place.longitude_deg + kHalfDegree),
      std::min(90.0, place.latitude_deg + kHalfDegree));
  proj_operation_factory_context_set_spatial_criterion(context, factory.get(),
                                                       PROJ_SPATIAL_CRITERION_PARTIAL_INTERSECTION);
  proj_operation_factory_context_set_grid_availability_use(context, factory.get(), PROJ_GRID_AVAILABILITY_IGNORED);
  const std::unique_ptr<PJ_OBJ_LIST, FreeList> list(proj_create_operations(context, source, target, factory.get()));
  const int count = list ? proj_list_get_count(list.get()) : 0;
  std::optional<Error> refusal;
  for (int i = 0; i < count; ++i) {
    const Pj candidate(proj_list_get(context, list.get(), i));
    if (!candidate || proj_coordoperation_has_ballpark_transformation(context, candidate.get()) != 0) continue;
    const auto missing = missing_grids(context, candidate.get());
    if (missing.empty() && proj_coordoperation_is_instantiable(context, candidate.get()) != 0) {
      Pj normalized(proj_normalize_for_visualization(context, candidate.get()));
      if (normalized) return {std::move(normalized), describe_operation(context, candidate.get())};
    }
    if (!refusal)
      refusal = mismatch("the best conversion to WGS84 needs a grid that is not installed: " +
                             (missing.empty() ? std::string("(unnamed)") : joined(missing)),
                         crs)
                    .hint("Put the file into PROJ's data folder (PROJ_DATA), or say that a coarser conversion will do");
    if (!accept_coarser) throw *refusal;
  }
  if (refusal) throw *refusal;
  throw mismatch("no known conversion between this CRS and WGS84 at the survey's place", crs)
      .hint("Check the CRS; a local or unknown datum must be replaced by the true one");
}

std::string point_text(const Vec3& p) {
  return base::to_text(p.x()) + " " + base::to_text(p.y()) + " " + base::to_text(p.z());
}

}  // namespace

CrsInfo describe_crs(const std::string& crs) {
  const Context context = make_context();
  const Pj pj = parse(context.get(), crs);
  return describe(context.get(), pj.get(), crs);
}

std::string crs_wkt(const std::string& crs) {
  const Context context = make_context();
  const Pj pj = parse(context.get(), crs);
  (void)describe(context.get(), pj.get(), crs);
  const char* const one_line[] = {"MULTILINE=NO", nullptr};
  const char* wkt = proj_as_wkt(context.get(), pj.get(), PJ_WKT2_2019, one_line);
  if (wkt == nullptr) throw mismatch("a CRS that cannot be written as WKT", crs);
  return wkt;
}

struct CrsConverter::Impl {
  explicit Impl(const LocalFrame& f) : frame(f), context(make_context()) {}

  LocalFrame frame;
  Context context;
  Operation operation;
  std::string crs;
  // Metres of one unit of z where the operation is horizontal only; z then bypasses PROJ.
  std::optional<double> z_factor;
  std::optional<double> radians_per_unit;  // of a geographic CRS
  mutable std::mutex turn;

  [[nodiscard]] Vec3 transform(PJ_DIRECTION direction, const Vec3& p) const {
    if (!p.allFinite()) refuse(p, "a point that is not finite");
    proj_errno_reset(operation.pj.get());
    const PJ_COORD out =
        proj_trans(operation.pj.get(), direction, proj_coord(p.x(), p.y(), z_factor ? 0.0 : p.z(), HUGE_VAL));
    const Vec3 q(out.xyz.x, out.xyz.y, z_factor ? p.z() : out.xyz.z);
    if (proj_errno(operation.pj.get()) != 0 || !q.allFinite()) refuse(p, "a point outside the area of the CRS");
    return q;
  }

  [[noreturn]] void refuse(const Vec3& p, const char* what) const {
    throw Error(ErrorCode::crs_mismatch, std::string(what) + " '" + shortened(crs) + "'")
        .found(point_text(p))
        .hint("Check that x is easting or longitude, y northing or latitude, and that the CRS is the data's own");
  }

  [[nodiscard]] Vec3 to_local(const Vec3& p) const {
    // PROJ would wrap metres given as degrees around the Earth without a word.
    if (radians_per_unit && (std::abs(p.x() * *radians_per_unit) > kTwoPi + 1e-9 ||
                             std::abs(p.y() * *radians_per_unit) > kTwoPi / 4.0 + 1e-9))
      refuse(p, "a longitude or latitude out of range in the CRS");
    Vec3 g = transform(PJ_FWD, p);
    if (z_factor) g.z() *= *z_factor;
    try {
      return frame.to_local({g.y(), g.x(), g.z()});
    } catch (Error& error) {
      error.in("point " + point_text(p));
      throw;
    }
  }

  [[nodiscard]] Vec3 from_local(const Vec3& p) const {
    if (!p.allFinite()) refuse(p, "a point that is not finite");
    const Geodetic g = frame.to_geodetic(p);
    return transform(PJ_INV, {g.longitude_deg, g.latitude_deg, z_factor ? g.height_m / *z_factor : g.height_m});
  }
};

CrsConverter::CrsConverter(const std::string& crs, const LocalFrame& frame, const CrsOptions& options)
    : impl_(std::make_unique<Impl>(frame)) {
  Impl& impl = *impl_;
  impl.crs = crs;
  PJ_CONTEXT* context = impl.context.get();
  Pj source = parse(context, crs);
  const CrsInfo info = describe(context, source.get(), crs);
  if (info.geographic) impl.radians_per_unit = info.horizontal_unit_m;
  constexpr double kUnitSlack = 1e-9;  // relative; the US survey foot differs from the foot by 2e-6
  if (!info.has_vertical && !info.geographic && std::abs(info.horizontal_unit_m - 1.0) > kUnitSlack)
    throw mismatch(
        "a CRS whose horizontal unit is not the metre and that declares no vertical unit: z could be in "
        "either",
        crs)
        .allowed("a compound CRS")
        .hint("Name the vertical CRS too, such as " +
              (info.authority_code.empty() ? std::string("EPSG:2227") : info.authority_code) +
              "+6360 (NAVD88 in US survey feet) or +5703 (NAVD88 in metres)");
  if (info.has_vertical && options.heights == Heights::keep_datum) {
    Pj plain = unbound(context, Pj(proj_clone(context, source.get())));
    if (plain && proj_get_type(plain.get()) == PJ_TYPE_COMPOUND_CRS) {
      source.reset(proj_crs_get_sub_crs(context, plain.get(), 0));
      impl.z_factor = info.vertical_is_depth ? -info.vertical_unit_m : info.vertical_unit_m;
    }
  } else if (!info.has_vertical) {
    impl.z_factor = 1.0;
  }
  const Pj target(proj_create(context, impl.z_factor ? "EPSG:4326" : "EPSG:4979"));
  if (!source || !target)
    throw Error(ErrorCode::crs_mismatch, "PROJ's database proj.db was not found").hint("Install proj-data");
  impl.operation = best_operation(context, source.get(), target.get(), frame.origin(), crs, options.accept_coarser);
  if (impl.z_factor)
    impl.operation.text += info.has_vertical
                               ? "; heights keep their datum, unit factor " + base::to_text(*impl.z_factor)
                               : std::string("; heights passed as metres");
}

CrsConverter::~CrsConverter() = default;
CrsConverter::CrsConverter(CrsConverter&&) noexcept = default;
CrsConverter& CrsConverter::operator=(CrsConverter&&) noexcept = default;

Vec3 CrsConverter::to_local(const Vec3& p_crs) const {
  const std::lock_guard lock(impl_->turn);
  return impl_->to_local(p_crs);
}

Vec3 CrsConverter::from_local(const Vec3& p_world) const {
  const std::lock_guard lock(impl_->turn);
  return impl_->from_local(p_world);
}

void CrsConverter::to_local(std::vector<Vec3>& points) const {
  const std::lock_guard lock(impl_->turn);
  for (auto& p : points) p = impl_->to_local(p);
}

void CrsConverter::from_local(std::vector<Vec3>& points) const {
  const std::lock_guard lock(impl_->turn);
  for (auto& p : points) p = impl_->from_local(p);
}

const std::string& CrsConverter::operation() const {
  return impl_->operation.text;
}

double geoid_undulation(const std::string& geoid, const Geodetic& position) {
  constexpr const char* kGrid = "egm96_15.gtx";
  if (geoid != "egm96")
    throw Error(ErrorCode::crs_mismatch, "a geoid that is not known").found("'" + geoid + "'").allowed("egm96");
  if (!(std::abs(position.latitude_deg) <= 90.0 && std::abs(position.longitude_deg) <= 180.0))
    throw Error(ErrorCode::crs_mismatch, "a position outside the Earth")
        .found(base::to_text(position.latitude_deg) + " " + base::to_text(position.longitude_deg))
        .allowed("latitude -90 to 90, longitude -180 to 180");
  thread_local const Context context = make_context();
  thread_local const Pj shift(proj_create(context.get(), "+proj=vgridshift +grids=egm96_15.gtx +multiplier=1"));
  if (!shift)
    throw Error(ErrorCode::crs_mismatch, std::string("the geoid's grid is not installed: ") + kGrid)
        .hint("Install proj-data, or put the file into PROJ's data folder (PROJ_DATA)");
  proj_errno_reset(shift.get());
  const PJ_COORD out =
      proj_trans(shift.get(), PJ_FWD,
                 proj_coord(proj_torad(position.longitude_deg), proj_torad(position.latitude_deg), 0.0, HUGE_VAL));
  if (proj_errno(shift.get()) != 0 || !std::isfinite(out.xyz.z))
    throw Error(ErrorCode::crs_mismatch, std::string("the geoid's grid has no value here: ") + kGrid)
        .found(base::to_text(position.latitude_deg) + " " + base::to_text(position.longitude_deg));
  return out.xyz.z;
}

}  // namespace cairn::geodesy
