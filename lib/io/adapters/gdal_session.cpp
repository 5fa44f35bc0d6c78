#include "io/adapters/gdal_session.hpp"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_vsi.h>
#include <gdal_frmts.h>
#include <gdal_priv.h>
#include <ogr_srs_api.h>
#include <ogrsf_frmts.h>

#include <atomic>
#include <mutex>

namespace cairn::io {
namespace {

void CPL_STDCALL collect(CPLErr level, CPLErrorNum, const char* text) {
  auto* messages = static_cast<GdalMessages*>(CPLGetErrorHandlerUserData());
  if (messages == nullptr || level == CE_None || level == CE_Debug) return;
  messages->add(level >= CE_Failure, text != nullptr ? text : "");
}

}  // namespace

void start_gdal() {
  static std::once_flag once;
  std::call_once(once, [] {
    CPLSetConfigOption("GDAL_PAM_ENABLED", "NO");                     // no .aux.xml, read or written
    CPLSetConfigOption("GDAL_DISABLE_READDIR_ON_OPEN", "EMPTY_DIR");  // no neighbours
    CPLSetConfigOption("GDAL_VRT_ENABLE_PYTHON", "NO");
    CPLSetConfigOption("CPL_VSIL_CURL_ALLOWED_FILENAME", "none");        // no file by network
    CPLSetConfigOption("GDAL_DRIVER_PATH", "disable");                   // no plug-ins
    CPLSetConfigOption("OGR_CURRENT_DATE", "2000-01-01T00:00:00.000Z");  // time stamps of GeoPackage
    CPLSetConfigOption("OGR_SQLITE_JOURNAL", "DELETE");
    CPLSetConfigOption("OGR_GPKG_ALLOW_THREADED_RTREE", "NO");
    CPLSetConfigOption("GDAL_NUM_THREADS", "1");
    OSRSetPROJEnableNetwork(0);
    GDALRegister_GTiff();
    GDALRegister_COG();
    GDALRegister_MEM();
    RegisterOGRGeoPackage();
    RegisterOGRGeoJSON();
    RegisterOGRShape();
  });
}

GdalMessages::GdalMessages() {
  CPLErrorReset();
  CPLPushErrorHandlerEx(collect, this);
}

GdalMessages::~GdalMessages() {
  CPLPopErrorHandler();
  CPLErrorReset();
}

void GdalMessages::add(bool is_failure, std::string_view text) {
  std::string& first = is_failure ? failure_ : warning_;
  if (first.empty()) first = text.empty() ? "unnamed problem" : std::string(text);
}

void GdalMessages::raise(base::ErrorCode code, std::string message, const std::filesystem::path& path) const {
  const std::string& said = failure_.empty() ? warning_ : failure_;
  if (!said.empty()) message += ": " + said;
  throw base::Error(code, std::move(message)).file(path.string());
}

std::string gdal_input_path(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    throw base::Error(base::ErrorCode::not_found, "no such file").file(path.string());
  const std::string absolute = std::filesystem::absolute(path).lexically_normal().string();
  if (absolute.rfind("/vsi", 0) == 0)
    throw base::Error(base::ErrorCode::not_found, "not a plain file").file(path.string());
  return absolute;
}

MemoryFile::MemoryFile(std::string_view extension) {
  static std::atomic<unsigned> count{0};
  folder_ = "/vsimem/cairn-" + std::to_string(count++);
  path_ = folder_ + "/file" + std::string(extension);
}

MemoryFile::~MemoryFile() {
  VSIRmdirRecursive(folder_.c_str());
}

std::string_view MemoryFile::bytes() const {
  vsi_l_offset size = 0;
  const GByte* data = VSIGetMemFileBuffer(path_.c_str(), &size, FALSE);
  return data == nullptr ? std::string_view()
                         : std::string_view(reinterpret_cast<const char*>(data), static_cast<std::size_t>(size));
}

}  // namespace cairn::io
