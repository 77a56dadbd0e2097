#include <algorithm>
#include <array>
#include <map>
#include <numeric>
#include <utility>

#include "solid/angle_kernel.hpp"

namespace veriflex::solid {

namespace {

using Arms = std::vector<std::int32_t>;

std::int32_t arm_a(const Angle& t) { return 2 * t.bond_a + (t.sign_a < 0 ? 1 : 0); }
std::int32_t arm_b(const Angle& t) { return 2 * t.bond_b + (t.sign_b < 0 ? 1 : 0); }

bool contains(const Arms& arms, std::int32_t arm) {
  return std::find(arms.begin(), arms.end(), arm) != arms.end();
}

// The smallest set of angles that shares no arm with another: in a lattice the angles of a node. Returns the
// angles' numbers, set by set, and where each set begins.
struct Sets {
  std::vector<std::size_t> order, begin;
};

Sets connected(const std::vector<Angle>& angles, std::size_t bonds) {
  std::vector<std::int32_t> parent(2 * bonds);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](std::int32_t arm) {
    while (parent[static_cast<std::size_t>(arm)] != arm) {
      std::int32_t& up = parent[static_cast<std::size_t>(arm)];
      up = parent[static_cast<std::size_t>(up)];
      arm = up;
    }
    return arm;
  };
  for (const Angle& t : angles) parent[static_cast<std::size_t>(root(arm_a(t)))] = root(arm_b(t));

  std::vector<std::int32_t> number(2 * bonds, -1);  // of the set with this root, in order of appearance
  std::vector<std::size_t> set_of(angles.size());
  Sets sets{std::vector<std::size_t>(angles.size()), {0}};
  for (std::size_t i = 0; i < angles.size(); ++i) {
    std::int32_t& set = number[static_cast<std::size_t>(root(arm_a(angles[i])))];
    if (set < 0) {
      set = static_cast<std::int32_t>(sets.begin.size() - 1);
      sets.begin.push_back(0);
    }
    set_of[i] = static_cast<std::size_t>(set);
    ++sets.begin[set_of[i] + 1];
  }
  std::partial_sum(sets.begin.begin(), sets.begin.end(), sets.begin.begin());
  std::vector<std::size_t> next = sets.begin;
  for (std::size_t i = 0; i < angles.size(); ++i) sets.order[next[set_of[i]]++] = i;
  return sets;
}

// Arms in an order that makes like nodes look alike: those that rest opposite each other first, in pairs.
Arms sorted_arms(const std::vector<Angle>& star) {
  Arms arms;
  const auto add = [&](std::int32_t arm) {
    if (!contains(arms, arm)) arms.push_back(arm);
  };
  for (const bool straight : {true, false}) {
    for (const Angle& t : star) {
      if (t.straight != straight) continue;
      add(arm_a(t));
      add(arm_b(t));
    }
  }
  return arms;
}

class Arrangement {
 public:
  void add(const std::vector<Angle>& star) {
    const Arms arms = sorted_arms(star);
    const auto number = [&](std::int32_t arm) {
      return static_cast<std::uint8_t>(std::find(arms.begin(), arms.end(), arm) - arms.begin());
    };
    std::vector<AngleStars::Pair> pairs;
    for (const Angle& t : star) {
      const auto [a, b] = std::minmax({number(arm_a(t)), number(arm_b(t))});
      pairs.push_back({a, b, t.straight});
    }
    std::sort(pairs.begin(), pairs.end());
    Arms& all = arms_of_shape_[pairs];
    all.insert(all.end(), arms.begin(), arms.end());
    if (++stars_ == AngleStars::max_stars) end_piece();
  }

  AngleStars result() && {
    end_piece();
    return std::move(result_);
  }

 private:
  void end_piece() {
    for (const auto& [pairs, by_star] : arms_of_shape_) {
      std::size_t arms = 0;
      for (const AngleStars::Pair& pair : pairs) arms = std::max<std::size_t>(arms, pair.b + 1U);
      AngleStars::Group group{pairs, by_star.size() / arms, 0, {}};
      group.lanes = (group.stars + 7) / 8 * 8;
      for (std::size_t arm = 0; arm < arms; ++arm) {
        for (std::size_t i = 0; i < group.lanes; ++i)
          group.arms.push_back(by_star[std::min(i, group.stars - 1) * arms + arm]);
      }
      result_.angle_count += group.stars * pairs.size();
      result_.groups.push_back(std::move(group));
    }
    arms_of_shape_.clear();
    stars_ = 0;
  }

  AngleStars result_;
  std::map<std::vector<AngleStars::Pair>, Arms> arms_of_shape_;  // of this piece, arms star by star
  std::size_t stars_ = 0;
};

}  // namespace

double AngleStars::bytes() const {
  double sum = static_cast<double>(groups.capacity() * sizeof(Group));
  for (const Group& group : groups) {
    sum += static_cast<double>(group.pairs.capacity() * sizeof(Pair) +
                               group.arms.capacity() * sizeof(std::int32_t));
  }
  return sum;
}

AngleStars arrange(const std::vector<Angle>& angles, std::size_t bonds) {
  const Sets sets = connected(angles, bonds);
  Arrangement arrangement;
  std::vector<Angle> star;
  Arms arms;
  for (std::size_t set = 0; set + 1 < sets.begin.size(); ++set) {
    for (std::size_t i = sets.begin[set]; i < sets.begin[set + 1]; ++i) {
      const Angle& t = angles[sets.order[i]];
      const std::size_t more = (contains(arms, arm_a(t)) ? 0U : 1U) + (contains(arms, arm_b(t)) ? 0U : 1U);
      if (arms.size() + more > AngleStars::max_arms) {
        arrangement.add(star);
        star.clear();
        arms.clear();
      }
      for (const std::int32_t arm : {arm_a(t), arm_b(t)}) {
        if (!contains(arms, arm)) arms.push_back(arm);
      }
      star.push_back(t);
    }
    arrangement.add(star);
    star.clear();
    arms.clear();
  }
  return std::move(arrangement).result();
}

}  // namespace veriflex::solid
