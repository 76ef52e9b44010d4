// Building the BVH over triangles.
#include "mesh_shape/triangle_tree.h"

#include "common/parallel_loop.h"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>

namespace
{
// Triangles that are worth a thread: about a millisecond.
constexpr size_t s_minPerThread = 10000;
// Halves are not equally large.
constexpr size_t s_runsPerWorker = 4;

struct Centroid
{
    btScalar at[3]; ///< three times the position
    uint32_t triangle;
};

/// Centroids to be sorted so that each run of `unit`, of an eighth of it, and so on down to `width` lies close
/// together.
struct Run
{
    Centroid *begin, *end;
    size_t unit;

    size_t Count() const
    {
        return size_t(end - begin);
    }
};

/// Divides a run of more than `width` centroids into two.
std::pair<Run, Run> Divide(Run run, size_t width)
{
    while (run.Count() <= run.unit)
        run.unit /= width;
    btScalar lower[3], upper[3];
    std::copy_n(run.begin->at, 3, lower);
    std::copy_n(run.begin->at, 3, upper);
    for (const Centroid* c = run.begin; c != run.end; c++)
        for (int axis = 0; axis < 3; axis++)
        {
            lower[axis] = std::min(lower[axis], c->at[axis]);
            upper[axis] = std::max(upper[axis], c->at[axis]);
        }
    int longest = 0;
    for (int axis = 1; axis < 3; axis++)
        if (upper[axis] - lower[axis] > upper[longest] - lower[longest])
            longest = axis;
    Centroid* middle = run.begin + ((run.Count() + run.unit - 1) / run.unit + 1) / 2 * run.unit;
    std::nth_element(run.begin, middle, run.end,
                     [longest](const Centroid& a, const Centroid& b) { return a.at[longest] < b.at[longest]; });
    return {{run.begin, middle, run.unit}, {middle, run.end, run.unit}};
}

void Sort(const Run& run, size_t width)
{
    if (run.Count() <= width)
        return;
    const auto [first, second] = Divide(run, width);
    Sort(first, width);
    Sort(second, width);
}

/// Divides a large run on several threads: those of each round are divided at the same time.
void SortInParallel(const Run& run, size_t width, uint32_t threads)
{
    std::vector<Run> runs = {run};
    const uint32_t workers = run.Count() > s_minPerThread ? threads : 1;
    while (workers > 1 && runs.size() < s_runsPerWorker * workers && runs[0].Count() > s_minPerThread)
    {
        std::vector<Run> halves(2 * runs.size());
        auto divide = [&](size_t i, uint32_t)
        {
            const Run& whole = runs[i];
            const Run none = {whole.end, whole.end, whole.unit};
            std::tie(halves[2 * i], halves[2 * i + 1]) =
                whole.Count() > s_minPerThread ? Divide(whole, width) : std::make_pair(whole, none);
        };
        qcForEach(workers, runs.size(), 1, divide);
        runs.swap(halves);
    }
    qcForEach(workers, runs.size(), 1, [&](size_t i, uint32_t) { Sort(runs[i], width); });
}
} // namespace

void qcTriangleTree::Clear(Block* block)
{
    constexpr btScalar infinity = std::numeric_limits<btScalar>::infinity();
    for (int axis = 0; axis < 3; axis++)
    {
        std::fill_n(block->lower[axis], s_width, infinity);
        std::fill_n(block->upper[axis], s_width, -infinity);
    }
}

/// Adds a level of boxes around the blocks of the top level.
void qcTriangleTree::AddLevel()
{
    Level below = m_levels.back();
    Level level = {uint32_t(m_blocks.size()), (below.count + s_width - 1) / s_width};
    m_blocks.resize(level.first + level.count);
    for (uint32_t b = 0; b < level.count; b++)
        Clear(&m_blocks[level.first + b]);
    for (uint32_t b = 0; b < below.count; b++)
    {
        const Block& child = m_blocks[below.first + b];
        Block& parent = m_blocks[level.first + b / s_width];
        for (int axis = 0; axis < 3; axis++)
        {
            parent.lower[axis][b % s_width] = *std::min_element(child.lower[axis], child.lower[axis] + s_width);
            parent.upper[axis][b % s_width] = *std::max_element(child.upper[axis], child.upper[axis] + s_width);
        }
    }
    m_levels.push_back(level);
}

qcTriangleTree::qcTriangleTree(const btVector3* vertices, const uint32_t* indices, uint32_t triangleCount,
                               uint32_t workers)
{
    if (triangleCount == 0)
        return;
    auto corner = [&](uint32_t t, int c) { return vertices[indices[3 * size_t(t) + size_t(c)]]; };
    std::vector<Centroid> centroids(triangleCount);
    for (uint32_t t = 0; t < triangleCount; t++)
    {
        centroids[t].triangle = t;
        for (int axis = 0; axis < 3; axis++)
            centroids[t].at[axis] = corner(t, 0)[axis] + corner(t, 1)[axis] + corner(t, 2)[axis];
    }
    size_t unit = s_width;
    while (unit < triangleCount)
        unit *= s_width;
    SortInParallel({centroids.data(), centroids.data() + triangleCount, unit}, s_width, workers);
    m_order.resize(triangleCount);
    m_levels.push_back({0, (triangleCount + s_width - 1) / s_width});
    m_blocks.resize(m_levels[0].count);
    for (Block& block : m_blocks)
        Clear(&block);
    for (uint32_t i = 0; i < triangleCount; i++)
    {
        uint32_t t = m_order[i] = centroids[i].triangle;
        Block& block = m_blocks[i / s_width];
        for (int axis = 0; axis < 3; axis++)
        {
            auto sides = std::minmax({corner(t, 0)[axis], corner(t, 1)[axis], corner(t, 2)[axis]});
            block.lower[axis][i % s_width] = sides.first;
            block.upper[axis][i % s_width] = sides.second;
        }
    }
    while (m_levels.back().count > 1)
        AddLevel();
}
