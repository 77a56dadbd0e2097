/// What every study of a bond law reports of it.
#pragma once

#include "bond/derive.hpp"
#include "observe/record.hpp"

namespace veriflex::measures {

/// Record `validity`: the strain intervals in which the law is as good as linear.
observe::Record validity_record(const bond::Derivation& derivation);

}  // namespace veriflex::measures
