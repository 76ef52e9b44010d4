// An independent check of which objects meet within a step: exact tests at moments of the linear motion of vertices.
#ifndef QC_TESTS_BULLET_SOFT_BODY_MEETING_ORACLE_H
#define QC_TESTS_BULLET_SOFT_BODY_MEETING_ORACLE_H

#include "bullet/mesh/motion_oracle.h"

#include <set>
#include <string>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

/// What the oracle follows of an object.
struct qcFollowedObject
{
    std::string name;
    const btCollisionObject* object;
    const void* owner;                  ///< objects of one owner may meet
    bool moves;                         ///< Bullet moves it; others may meet each other
    bool isConvex;                      ///< convex shapes may meet each other
    std::function<qcWorldMesh()> inner; ///< what no other object passes
    std::function<qcWorldMesh()> outer; ///< with as many vertices: objects whose outer triangles meet at the start of
                                        ///< a step may meet within it
};

/// Names the pairs of objects that meet within a step, though they did not at its start.
class qcMeetingOracle
{
  public:
    void Add(qcFollowedObject object)
    {
        const qcBodyId id = m_triangles.Add(object.inner());
        m_entries.push_back({std::move(object), id, {}});
    }
    void Remove(const btCollisionObject* object)
    {
        auto isIt = [object](const Entry& entry) { return entry.followed.object == object; };
        auto found = std::find_if(m_entries.begin(), m_entries.end(), isIt);
        m_triangles.Remove(found->id);
        m_entries.erase(found);
    }

    /// The step starts with the objects where they are.
    void Begin()
    {
        for (Entry& entry : m_entries)
        {
            entry.start = entry.followed.inner().positions;
            m_triangles.Place(entry.id, entry.followed.outer().positions);
        }
        m_meetings = FindMeetings();
    }
    /// The step ends with the objects where they are. Returns the names of those that have met in it.
    std::vector<std::string> End()
    {
        std::set<Pair> met;
        std::vector<std::vector<double>> ends;
        for (const Entry& entry : m_entries)
            ends.push_back(entry.followed.inner().positions);
        for (int k = 1; k <= s_moments; k++)
        {
            for (size_t i = 0; i < m_entries.size(); i++)
                m_triangles.PlaceBetween(m_entries[i].id, m_entries[i].start, ends[i], double(k) / s_moments);
            for (const Pair& pair : FindMeetings())
                if (m_meetings.count(pair) == 0)
                    met.insert(pair);
        }
        std::vector<std::string> names;
        for (const Pair& pair : met)
            names.push_back(m_entries[pair.first].followed.name + ", " + m_entries[pair.second].followed.name);
        return names;
    }

  private:
    static constexpr int s_moments = 8;

    struct Entry
    {
        qcFollowedObject followed;
        qcBodyId id;
        std::vector<double> start;
    };
    using Pair = std::pair<size_t, size_t>; ///< indices of entries, the smaller one first

    static bool MayMeet(const qcFollowedObject& a, const qcFollowedObject& b)
    {
        return !(a.moves || b.moves) || (a.isConvex && b.isConvex) || (a.owner != nullptr && a.owner == b.owner);
    }
    std::set<Pair> FindMeetings()
    {
        const qcResult& result = m_triangles.Detect();
        auto indexOf = [this](uint32_t slot)
        {
            return size_t(std::find_if(m_entries.begin(), m_entries.end(),
                                       [slot](const Entry& entry) { return entry.id.slot == slot; }) -
                          m_entries.begin());
        };
        std::set<Pair> meetings;
        for (size_t i = 0; i < result.pairCount; i++)
        {
            const Pair pair = std::minmax(indexOf(result.pairs[i].bodyA), indexOf(result.pairs[i].bodyB));
            if (!MayMeet(m_entries[pair.first].followed, m_entries[pair.second].followed))
                meetings.insert(pair);
        }
        return meetings;
    }

    qcPlacedTriangles m_triangles;
    std::vector<Entry> m_entries;
    std::set<Pair> m_meetings; ///< at the start of the step
};

#endif
