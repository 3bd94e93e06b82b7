#include "common/model/precision.h"

#include "common/base/check.h"

namespace powderkeg {

std::string_view NameOf(Precision precision) {
  switch (precision) {
    case Precision::kFp32: return "fp32";
    case Precision::kBf16: return "bf16";
    case Precision::kFp16: return "fp16";
    case Precision::kInt8: return "int8";
  }
  return "unknown";
}

Precision PrecisionByName(std::string_view name) {
  for (const Precision precision :
       {Precision::kFp32, Precision::kBf16, Precision::kFp16, Precision::kInt8}) {
    if (NameOf(precision) == name) return precision;
  }
  throw Error(StrCat("unknown precision '", name, "', expected fp32, bf16, fp16 or int8"));
}

}  // namespace powderkeg
