// Quick-CULLIDE on the triangles of a world, in a scene of its own: the window measures, the simulation goes on.
#ifndef QC_DEMOS_VIEW_CULLING_H
#define QC_DEMOS_VIEW_CULLING_H

#include "view/geometry.h"

#include "quickcullide/quickcullide.h"

#include <string>

/// How Quick-CULLIDE is run. Few views and rounds leave large sets.
struct qcViewRequest
{
    int resolutionPower = 9; ///< pixels on a side, as a power of two
    int views = 1;           ///< index in qcViewAxes
    int rounds = 1;          ///< over the views

    bool operator==(const qcViewRequest& other) const
    {
        return resolutionPower == other.resolutionPower && views == other.views && rounds == other.rounds;
    }
};

constexpr const char* qcViewAxes[] = {"z", "xz", "xyz"};

/// Sizes and time of the last query.
struct qcViewSets
{
    uint32_t ffv = 0, sfv = 0, nfv = 0; ///< triangles; in two sets at most (see qcTriangleSets), counted in the worse
    size_t pairs = 0;                   ///< that the exact test confirms
    uint32_t resolution = 0;
    double ms = 0;
};

class qcViewCulling
{
  public:
    /// A device without GL has no sets.
    explicit qcViewCulling(qcDevice* device) : m_device(device)
    {
    }
    ~qcViewCulling();
    qcViewCulling(const qcViewCulling&) = delete;
    qcViewCulling& operator=(const qcViewCulling&) = delete;

    /// Runs the query on these surfaces. False with a message.
    bool Run(const std::vector<qcViewSurface>& surfaces, const qcViewRequest& request, std::string* message);

    const qcViewSets& Sets() const
    {
        return m_sets;
    }
    /// Calls function(surface index, triangle, set) for each triangle of the PCS of the last query.
    template <typename Function> void ForEach(Function function) const
    {
        for (const Marked& marked : m_marked)
            function(marked.surface, marked.triangle, marked.set);
    }

  private:
    struct Body
    {
        uint64_t triangles; ///< id
        qcBodyId id;
    };
    struct Marked
    {
        size_t surface;
        uint32_t triangle;
        qcVisibilitySet set;
    };

    bool Check(qcStatus status, std::string* message);
    bool Sync(const std::vector<qcViewSurface>& surfaces, std::string* message);
    bool Add(const qcViewSurface& surface, Body* body, std::string* message);
    void Read(const qcResult& result, const std::vector<qcViewSurface>& surfaces);

    qcDevice* m_device;
    qcScene* m_scene = nullptr;
    std::vector<Body> m_bodies; ///< one for each surface; generation 0: none
    std::vector<Marked> m_marked;
    qcViewSets m_sets;
};

#endif
