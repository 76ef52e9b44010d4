// Loops whose boxes meet, by sweep and prune along the longest axis.
#include "fracture/loop_groups.h"

#include "common/union_find.h"

#include <algorithm>
#include <numeric>

namespace
{
constexpr double s_margin = 1e-12; ///< of boxes, in units: loops that touch but for rounding meet
}

std::vector<qcClipLoops> qcGroupLoops(const std::vector<qcClipPoint>& points, const qcClipLoops& loops)
{
    struct Box
    {
        qcClipPoint lower, upper;
    };
    std::vector<Box> boxes;
    for (size_t loop = 0; loop < loops.ends.size(); loop++)
    {
        Box box = {points[loops.points[loops.Begin(loop)]], points[loops.points[loops.Begin(loop)]]};
        for (size_t i = loops.Begin(loop); i < loops.ends[loop]; i++)
            for (size_t axis = 0; axis < 3; axis++)
            {
                box.lower[axis] = std::min(box.lower[axis], points[loops.points[i]][axis] - s_margin);
                box.upper[axis] = std::max(box.upper[axis], points[loops.points[i]][axis] + s_margin);
            }
        boxes.push_back(box);
    }
    const size_t longest = qcLongestAxis(boxes, [](const Box& box, size_t axis) { return box.lower[axis]; });
    std::vector<uint32_t> order(boxes.size()), open;
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b)
              { return std::make_pair(boxes[a].lower[longest], a) < std::make_pair(boxes[b].lower[longest], b); });
    qcUnionFind groups;
    groups.Reset(boxes.size());
    for (uint32_t loop : order)
    {
        const Box& box = boxes[loop];
        auto isPassed = [&](uint32_t other) { return boxes[other].upper[longest] < box.lower[longest]; };
        open.erase(std::remove_if(open.begin(), open.end(), isPassed), open.end());
        for (uint32_t other : open)
        {
            bool meets = true;
            for (size_t axis = 0; axis < 3; axis++)
                meets =
                    meets && boxes[other].lower[axis] <= box.upper[axis] && boxes[other].upper[axis] >= box.lower[axis];
            if (meets)
                groups.Unite(loop, other);
        }
        open.push_back(loop);
    }
    std::vector<qcClipLoops> grouped;
    std::vector<size_t> groupOf(boxes.size());
    for (uint32_t loop = 0; loop < boxes.size(); loop++)
    {
        const uint32_t first = groups.Find(loop);
        if (first == loop)
        {
            groupOf[loop] = grouped.size();
            grouped.emplace_back();
        }
        qcClipLoops& group = grouped[groupOf[first]];
        group.points.insert(group.points.end(), loops.points.begin() + std::ptrdiff_t(loops.Begin(loop)),
                            loops.points.begin() + std::ptrdiff_t(loops.ends[loop]));
        group.ends.push_back(group.points.size());
    }
    return grouped;
}
