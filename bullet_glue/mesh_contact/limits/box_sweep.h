// Sweep and prune over the boxes of objects, along the axis on which they are spread most.
#ifndef QC_GLUE_MESH_CONTACT_LIMITS_BOX_SWEEP_H
#define QC_GLUE_MESH_CONTACT_LIMITS_BOX_SWEEP_H

#include "mesh_contact/limits/swept_object.h"

#include <algorithm>
#include <array>
#include <vector>

/// The axis on which the centres of boxes have the largest variance; 0 if there are none. O(n).
template <class Object> int qcAxisOfSpread(const std::vector<Object*>& objects)
{
    std::array<double, 3> mean{}, variance{};
    const double share = 1 / double(std::max<size_t>(objects.size(), 1));
    auto centreOf = [](const Object& object, int axis)
    { return (double(object.lower[axis]) + double(object.upper[axis])) / 2; };
    for (int axis = 0; axis < 3; axis++)
    {
        for (const Object* object : objects)
            mean[size_t(axis)] += share * centreOf(*object, axis);
        for (const Object* object : objects)
        {
            const double from = centreOf(*object, axis) - mean[size_t(axis)];
            variance[size_t(axis)] += share * from * from;
        }
    }
    return int(std::max_element(variance.begin(), variance.end()) - variance.begin());
}

/// Calls visit(a, b) for the pairs of objects whose boxes overlap along one axis, if contact of one of the two is
/// computed here and one moves. O(n log n) and the visits.
template <class Visit> void qcSweepBoxes(const std::vector<qcSweptObject*>& objects, const Visit& visit)
{
    const int axis = qcAxisOfSpread(objects);
    std::vector<qcSweptObject*> byLower = objects;
    std::sort(byLower.begin(), byLower.end(),
              [axis](const qcSweptObject* a, const qcSweptObject* b)
              { return std::make_pair(a->lower[axis], a->number) < std::make_pair(b->lower[axis], b->number); });
    // Lists of partners: all objects, those that move, those of ours, those of ours that move.
    constexpr size_t mustMove = 1, mustBeOurs = 2;
    std::array<std::vector<size_t>, 4> partners;
    for (size_t kind = 0; kind < partners.size(); kind++)
        for (size_t i = 0; i < byLower.size(); i++)
            if ((byLower[i]->moves || (kind & mustMove) == 0) && (byLower[i]->isOurs || (kind & mustBeOurs) == 0))
                partners[kind].push_back(i);
    std::array<size_t, 4> next{};
    for (size_t i = 0; i < byLower.size(); i++)
    {
        qcSweptObject* first = byLower[i];
        const size_t kind = (first->moves ? 0 : mustMove) | (first->isOurs ? 0 : mustBeOurs);
        const std::vector<size_t>& list = partners[kind];
        while (next[kind] < list.size() && list[next[kind]] <= i)
            next[kind]++;
        for (size_t k = next[kind]; k < list.size() && byLower[list[k]]->lower[axis] <= first->upper[axis]; k++)
            visit(first, byLower[list[k]]);
    }
}

#endif
