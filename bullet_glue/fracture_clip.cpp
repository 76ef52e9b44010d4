// The face that closes a cut is bounded by the edges that have lost their other triangle: these are found by index, so
// that it closes whatever rounding did to the points. What is left open (loops without area, or that cross themselves)
// is closed by fans.
#include "fracture_face.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace
{
//  ---- tables ----------------------------------------------------------------------------------------

uint64_t Mix(uint64_t hash, uint64_t bits)
{
    hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
    return hash ^ hash >> 32;
}

uint64_t HashOf(uint64_t key)
{
    return Mix(0, key);
}

uint64_t HashOf(const qcClipPoint& point)
{
    uint64_t hash = 0;
    for (double x : point)
    {
        x += 0.0; // -0 becomes +0, which compares equal
        uint64_t bits;
        std::memcpy(&bits, &x, sizeof bits);
        hash = Mix(hash, bits);
    }
    return hash;
}

/// Numbers by key. Cuts make thousands of small ones: two blocks of memory each, and none for an empty one.
template <typename Key> class Table
{
  public:
    /// The number of a key; the one given here if it has none yet.
    uint32_t FindOrAdd(const Key& key, uint32_t number)
    {
        if (2 * m_entries.size() >= m_slots.size())
            Grow();
        uint32_t& slot = SlotOf(key);
        if (slot == 0)
        {
            m_entries.push_back({key, number});
            slot = uint32_t(m_entries.size());
        }
        return m_entries[slot - 1].number;
    }

  private:
    struct Entry
    {
        Key key;
        uint32_t number;
    };

    uint32_t& SlotOf(const Key& key)
    {
        size_t mask = m_slots.size() - 1, place = HashOf(key) & mask;
        while (m_slots[place] != 0 && m_entries[m_slots[place] - 1].key != key)
            place = (place + 1) & mask;
        return m_slots[place];
    }

    void Grow()
    {
        m_slots.assign(std::max<size_t>(64, 4 * m_slots.size()), 0);
        for (size_t i = 0; i < m_entries.size(); i++)
            SlotOf(m_entries[i].key) = uint32_t(i + 1);
    }

    std::vector<Entry> m_entries;
    std::vector<uint32_t> m_slots; ///< a power of two of them, half empty at least; 0, or one more than an entry
};

//  ---- edges -----------------------------------------------------------------------------------------

uint64_t EdgeKey(uint32_t a, uint32_t b)
{
    return uint64_t(std::min(a, b)) << 32 | std::max(a, b);
}

double SideOf(const qcClipPlane& plane, const qcClipPoint& p)
{
    return qcDotOf(plane.normal, p) - plane.distance;
}

/// An edge by its key, and how much more often it is passed from the lower index to the higher one than back.
struct EdgeCount
{
    uint64_t key;
    int count;
};

/// Edges among all points, or among those with a flag, by key.
std::vector<EdgeCount> CountEdges(const std::vector<qcClipTriangle>& triangles, const std::vector<uint8_t>* among)
{
    std::vector<EdgeCount> edges;
    for (const qcClipTriangle& triangle : triangles)
    {
        const std::array<uint32_t, 3>& v = triangle.corner;
        if (among != nullptr && (*among)[v[0]] + (*among)[v[1]] + (*among)[v[2]] < 2)
            continue;
        for (size_t c = 0; c < 3; c++)
        {
            uint32_t a = v[c], b = v[(c + 1) % 3];
            if (among == nullptr || ((*among)[a] && (*among)[b]))
                edges.push_back({EdgeKey(a, b), a < b ? 1 : a > b ? -1 : 0});
        }
    }
    std::sort(edges.begin(), edges.end(), [](const EdgeCount& a, const EdgeCount& b) { return a.key < b.key; });
    size_t count = 0;
    for (const EdgeCount& edge : edges)
        if (count != 0 && edges[count - 1].key == edge.key)
            edges[count - 1].count += edge.count;
        else
            edges[count++] = edge;
    edges.resize(count);
    return edges;
}

//  ---- the cut ---------------------------------------------------------------------------------------

struct Cutter
{
    qcClipMesh* mesh;
    std::vector<double> side; ///< of points; 0: of those that were made
    std::vector<qcClipTriangle> kept;
    Table<uint64_t> crossings;

    bool IsOutside(uint32_t point) const
    {
        return side[point] > 0;
    }

    /// Where an edge meets the plane. Always from the lower index on: both triangles get one point.
    uint32_t Crossing(uint32_t a, uint32_t b)
    {
        uint32_t made = uint32_t(mesh->points.size()), known = crossings.FindOrAdd(EdgeKey(a, b), made);
        if (known != made)
            return known;
        uint32_t low = std::min(a, b), high = std::max(a, b);
        double t = side[low] / (side[low] - side[high]);
        qcClipPoint p;
        for (size_t i = 0; i < 3; i++)
            p[i] = mesh->points[low][i] + t * (mesh->points[high][i] - mesh->points[low][i]);
        mesh->points.push_back(p);
        side.push_back(0);
        return made;
    }

    void Take(const qcClipTriangle& triangle)
    {
        const std::array<uint32_t, 3>& v = triangle.corner;
        int outside = IsOutside(v[0]) + IsOutside(v[1]) + IsOutside(v[2]);
        if (outside == 0)
            kept.push_back(triangle);
        if (outside == 0 || outside == 3)
            return;
        // From the corner that is alone on its side.
        size_t first = 0;
        while (IsOutside(v[first]) != (outside == 1))
            first++;
        uint32_t a = v[first], b = v[(first + 1) % 3], c = v[(first + 2) % 3];
        uint32_t ab = Crossing(a, b), ca = Crossing(c, a);
        if (outside == 2)
        {
            kept.push_back({{a, ab, ca}, triangle.face});
            return;
        }
        kept.push_back({{ab, b, c}, triangle.face});
        kept.push_back({{ab, c, ca}, triangle.face});
    }
};

//  ---- loops --------------------------------------------------------------------------------------

struct Arrow
{
    uint32_t from, to;
    bool passed;
};

/// The first arrow from a point that no loop has passed, or the end.
std::vector<Arrow>::iterator FindArrow(std::vector<Arrow>* arrows, uint32_t from)
{
    auto isBefore = [](const Arrow& arrow, uint32_t point) { return arrow.from < point; };
    auto found = std::lower_bound(arrows->begin(), arrows->end(), from, isBefore);
    while (found != arrows->end() && found->from == from && found->passed)
        ++found;
    return found != arrows->end() && found->from == from ? found : arrows->end();
}

/// Each arrow begins where another ends.
qcClipLoops ChainArrows(std::vector<Arrow>* arrows)
{
    auto isBefore = [](const Arrow& a, const Arrow& b) { return a.from < b.from; };
    std::stable_sort(arrows->begin(), arrows->end(), isBefore);
    qcClipLoops loops;
    for (auto first = arrows->begin(); first != arrows->end(); ++first)
    {
        if (first->passed)
            continue;
        std::vector<uint32_t> loop;
        for (auto arrow = first; arrow != arrows->end(); arrow = FindArrow(arrows, arrow->to))
        {
            loop.push_back(arrow->from);
            arrow->passed = true;
        }
        loops.push_back(std::move(loop));
    }
    return loops;
}

/// Loops of edges that are passed more often one way than the other: `turned`, in the way that is missing.
qcClipLoops FindLoops(const std::vector<qcClipTriangle>& triangles, const std::vector<uint8_t>* among, bool turned)
{
    std::vector<Arrow> arrows;
    for (const EdgeCount& edge : CountEdges(triangles, among))
    {
        uint32_t low = uint32_t(edge.key >> 32), high = uint32_t(edge.key);
        for (int k = 0; k < std::abs(edge.count); k++)
            arrows.push_back((edge.count > 0) == turned ? Arrow{high, low, false} : Arrow{low, high, false});
    }
    return ChainArrows(&arrows);
}

//  ---- points ----------------------------------------------------------------------------------------

/// As qcClipMesh_Weld; only points with a flag may be where another is. Points come in the order in which triangles
/// have them, whatever the flags.
void Weld(qcClipMesh* mesh, const std::vector<uint8_t>& mayCoincide)
{
    constexpr uint32_t none = UINT32_MAX;
    Table<qcClipPoint> places;
    std::vector<uint32_t> placeOf(mesh->points.size(), none);
    std::vector<qcClipPoint> points;
    for (qcClipTriangle& triangle : mesh->triangles)
        for (uint32_t& corner : triangle.corner)
        {
            uint32_t& place = placeOf[corner];
            if (place == none)
            {
                const qcClipPoint& point = mesh->points[corner];
                place = uint32_t(points.size());
                if (mayCoincide[corner])
                    place = places.FindOrAdd(point, place);
                if (place == points.size())
                    points.push_back(point);
            }
            corner = place;
        }
    mesh->points = std::move(points);
    auto isNothing = [](const qcClipTriangle& t)
    { return t.corner[0] == t.corner[1] || t.corner[1] == t.corner[2] || t.corner[2] == t.corner[0]; };
    mesh->triangles.erase(std::remove_if(mesh->triangles.begin(), mesh->triangles.end(), isNothing),
                          mesh->triangles.end());
}

//  ---- faces made anew -------------------------------------------------------------------------------

/// Points that three faces have, or more. Where there are two, they meet in a line through the point.
std::vector<uint8_t> FindVertices(const qcClipMesh& mesh)
{
    constexpr uint32_t none = UINT32_MAX;
    std::vector<std::array<uint32_t, 2>> faces(mesh.points.size(), {none, none});
    std::vector<uint8_t> isVertex(mesh.points.size(), false);
    for (const qcClipTriangle& triangle : mesh.triangles)
        for (uint32_t corner : triangle.corner)
        {
            std::array<uint32_t, 2>& known = faces[corner];
            if (known[0] == triangle.face || known[1] == triangle.face)
                continue;
            if (known[0] == none)
                known[0] = triangle.face;
            else if (known[1] == none)
                known[1] = triangle.face;
            else
                isVertex[corner] = true;
        }
    return isVertex;
}

/// The direction that the loops face, by twice their area.
qcClipPoint NormalOf(const qcClipMesh& mesh, const qcClipLoops& loops)
{
    qcClipPoint normal = {0, 0, 0};
    for (const std::vector<uint32_t>& loop : loops)
        for (size_t i = 0; i < loop.size(); i++)
        {
            const qcClipPoint &from = mesh.points[loop[0]], &a = mesh.points[loop[i]],
                              &b = mesh.points[loop[(i + 1) % loop.size()]];
            for (size_t k = 0; k < 3; k++)
            {
                size_t u = (k + 1) % 3, v = (k + 2) % 3;
                normal[k] += (a[u] - from[u]) * (b[v] - from[v]) - (a[v] - from[v]) * (b[u] - from[u]);
            }
        }
    return normal;
}
} // namespace

void qcClipMesh_Weld(qcClipMesh* mesh)
{
    Weld(mesh, std::vector<uint8_t>(mesh->points.size(), true));
}

size_t qcClipMesh_FindOpenTriangle(const qcClipMesh& mesh)
{
    std::vector<EdgeCount> edges = CountEdges(mesh.triangles, nullptr);
    edges.erase(std::remove_if(edges.begin(), edges.end(), [](const EdgeCount& edge) { return edge.count == 0; }),
                edges.end());
    auto isBefore = [](const EdgeCount& edge, uint64_t key) { return edge.key < key; };
    for (size_t i = 0; i < mesh.triangles.size() && !edges.empty(); i++)
        for (size_t c = 0; c < 3; c++)
        {
            uint64_t key = EdgeKey(mesh.triangles[i].corner[c], mesh.triangles[i].corner[(c + 1) % 3]);
            auto found = std::lower_bound(edges.begin(), edges.end(), key, isBefore);
            if (found != edges.end() && found->key == key)
                return i;
        }
    return mesh.triangles.size();
}

double qcClipMesh_Measure(const qcClipMesh& mesh, qcClipPoint* first)
{
    double volume = 0;
    *first = {0, 0, 0};
    if (mesh.points.empty())
        return 0;
    // Tetrahedra from a point of the mesh: from far away they would cancel.
    const qcClipPoint& from = mesh.points[0];
    for (const qcClipTriangle& triangle : mesh.triangles)
    {
        qcClipPoint e[3];
        for (size_t c = 0; c < 3; c++)
            for (size_t i = 0; i < 3; i++)
                e[c][i] = mesh.points[triangle.corner[c]][i] - from[i];
        double six = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
                     e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
                     e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
        volume += six / 6;
        for (size_t i = 0; i < 3; i++)
            (*first)[i] += six / 24 * (e[0][i] + e[1][i] + e[2][i]);
    }
    for (size_t i = 0; i < 3; i++)
        (*first)[i] += volume * from[i];
    return volume;
}

void qcClipMesh_Simplify(qcClipMesh* mesh)
{
    std::vector<uint8_t> isVertex = FindVertices(*mesh);
    std::vector<qcClipTriangle> sorted = mesh->triangles, face;
    auto isBefore = [](const qcClipTriangle& a, const qcClipTriangle& b) { return a.face < b.face; };
    std::stable_sort(sorted.begin(), sorted.end(), isBefore);
    qcClipMesh made;
    made.points = mesh->points;
    for (auto first = sorted.begin(), end = first; first != sorted.end(); first = end)
    {
        end = std::upper_bound(first, sorted.end(), *first, isBefore);
        // Most are a triangle of the mesh, or a corner of one.
        if (end - first == 1 && isVertex[first->corner[0]] && isVertex[first->corner[1]] && isVertex[first->corner[2]])
        {
            made.triangles.push_back(*first);
            continue;
        }
        face.assign(first, end);
        qcClipLoops loops = FindLoops(face, nullptr, false);
        for (std::vector<uint32_t>& loop : loops)
            loop.erase(std::remove_if(loop.begin(), loop.end(), [&](uint32_t point) { return !isVertex[point]; }),
                       loop.end());
        qcClipFace_Add(&made, NormalOf(made, loops), first->face, loops);
    }
    qcClipMesh_Weld(&made);
    // Where rounding has bent an outline, splinters do no harm.
    if (qcClipMesh_FindOpenTriangle(made) == made.triangles.size())
        *mesh = std::move(made);
    mesh->leastTriangles = mesh->triangles.size();
}

void qcClipMesh_Cut(qcClipMesh* mesh, const qcClipPlane& plane)
{
    Cutter cutter{mesh, {}, {}, {}};
    cutter.side.reserve(2 * mesh->points.size());
    bool anyOutside = false;
    for (const qcClipPoint& point : mesh->points)
    {
        cutter.side.push_back(SideOf(plane, point));
        anyOutside = anyOutside || cutter.side.back() > 0;
    }
    if (!anyOutside)
        return;
    cutter.kept.reserve(mesh->triangles.size());
    for (const qcClipTriangle& triangle : mesh->triangles)
        cutter.Take(triangle);
    mesh->triangles = std::move(cutter.kept);
    std::vector<uint8_t> onPlane(cutter.side.size());
    for (size_t i = 0; i < cutter.side.size(); i++)
        onPlane[i] = cutter.side[i] == 0;
    qcClipFace_Add(mesh, plane.normal, plane.face, FindLoops(mesh->triangles, &onPlane, true));
    onPlane.resize(mesh->points.size(), true);
    qcClipFace_AddFans(mesh, plane.face, FindLoops(mesh->triangles, &onPlane, true));
    // What is off the plane is where it was, and apart from all others as before.
    onPlane.resize(mesh->points.size(), true);
    Weld(mesh, onPlane);
    // A cut along a cut goes through its triangles one by one, and the next has more of them.
    mesh->leastTriangles = std::min(mesh->leastTriangles, mesh->triangles.size());
    if (mesh->triangles.size() > mesh->leastTriangles + mesh->leastTriangles / 2)
        qcClipMesh_Simplify(mesh);
}
