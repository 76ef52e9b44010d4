// The bodies of the breaking scene in a comparison of all methods.
#include "breaking/comparison.h"

#include "common/bullet/mesh_body.h"

namespace
{
constexpr double s_nearMargin = 0.01; // m
constexpr uint32_t s_noPiece = UINT32_MAX;

qcBodyDef BodyOf(const qcMeshShape& shape, const btTransform& place, qcActivity activity)
{
    qcBodyDef def = qcMeshBodyDef(shape, place);
    def.activity = activity;
    return def;
}

qcDetectDef NearRequest(const qcDetectDef& request, bool (*filter)(void*, uint32_t, uint32_t), void* context)
{
    qcDetectDef near = request;
    near.margin = s_nearMargin;
    near.pairFilter = filter;
    near.pairFilterContext = context;
    return near;
}
} // namespace

qcBreakingComparison::qcBreakingComparison(const qcBreakingWorld& world, qcDevice* device, const qcDetectDef& request)
    : m_world(world), m_comparison(device, request), m_near(device, NearRequest(request, MayMeet, this))
{
}

/// False for two pieces of one island.
bool qcBreakingComparison::MayMeet(void* context, uint32_t slotA, uint32_t slotB)
{
    auto* comparison = static_cast<const qcBreakingComparison*>(context);
    uint32_t a = comparison->m_pieceOfSlot[slotA], b = comparison->m_pieceOfSlot[slotB];
    return a == s_noPiece || b == s_noPiece || !comparison->m_world.AreJoined(a, b);
}

/// Adds a body to both comparisons, which name it alike.
bool qcBreakingComparison::Add(const qcMeshShape& shape, const btTransform& place, qcActivity activity, qcBodyId* id)
{
    qcBodyDef def = BodyOf(shape, place, activity);
    bool added = m_comparison.Add(def, id) && m_near.Add(def, id);
    if (added && m_pieceOfSlot.size() <= id->slot)
        m_pieceOfSlot.resize(id->slot + 1, s_noPiece);
    return added;
}

bool qcBreakingComparison::Begin(const char* record)
{
    const qcBreakingModel& model = m_world.Model();
    size_t count = model.shapes.size();
    m_pieces.resize(count);
    m_isStanding.assign(count, true);
    bool added = Add(*model.bunny.shape, m_world.BunnyPlace(), qc_activityMoving, &m_bunny);
    for (uint32_t i = 0; i < count && added; i++)
    {
        m_places.push_back(m_world.PiecePlace(i));
        added = Add(*model.shapes[i], m_places[i], qc_activityStatic, &m_pieces[i]);
        if (added)
            m_pieceOfSlot[m_pieces[i].slot] = i;
    }
    return added && m_comparison.Warm() && (record == nullptr || m_comparison.Record(record));
}

/// Takes over what has moved and what has broken off.
bool qcBreakingComparison::Place()
{
    auto move = [this](qcBodyId id, const btTransform& place)
    {
        return m_comparison.SetTransform(id, qcBodyTransformOf(place)) &&
               m_near.SetTransform(id, qcBodyTransformOf(place));
    };
    bool done = move(m_bunny, m_world.BunnyPlace());
    for (uint32_t i = 0; i < m_pieces.size() && done; i++)
    {
        if (m_isStanding[i] && m_world.PieceState(i) != qc_pieceStanding)
        {
            m_isStanding[i] = false;
            done = m_comparison.SetActivity(m_pieces[i], qc_activityMoving) &&
                   m_near.SetActivity(m_pieces[i], qc_activityMoving);
        }
        btTransform place = m_world.PiecePlace(i);
        if (done && !(place == m_places[i]))
            done = move(m_pieces[i], place);
        m_places[i] = place;
    }
    return done;
}

bool qcBreakingComparison::Run(bool compareAll, qcQueryResults* results)
{
    qcQueryResult near;
    return Place() && m_near.Run(qc_querySweep, &near) && m_comparison.RunEachStep(results) &&
           (!compareAll || (m_comparison.RunSampled(results) && m_comparison.CountMissed(results)));
}

qcBreakingMarks qcBreakingComparison::MarksOf(const qcQueryComparison& comparison, qcComparedQuery query) const
{
    qcBreakingMarks marks;
    marks.bunny = comparison.Marked(query, m_bunny);
    for (qcBodyId piece : m_pieces)
        marks.pieces.push_back(comparison.Marked(query, piece));
    return marks;
}

bool qcCountPenetrating(const qcBreakingWorld& world, size_t* pairs)
{
    const qcBreakingModel& model = world.Model();
    qcSceneDef sceneDef = qcDefaultSceneDef();
    qcScene* scene = nullptr;
    qcBodyId id;
    qcStatus status = qcScene_Create(&sceneDef, &scene);
    qcBodyDef bunny = BodyOf(*model.bunny.shape, world.BunnyPlace(), qc_activityMoving);
    if (status == qc_statusOk)
        status = qcScene_AddBody(scene, &bunny, &id);
    for (uint32_t i = 0; i < model.shapes.size() && status == qc_statusOk; i++)
    {
        bool stands = world.PieceState(i) == qc_pieceStanding;
        qcBodyDef def = BodyOf(*model.shapes[i], world.PiecePlace(i), stands ? qc_activityStatic : qc_activityMoving);
        status = qcScene_AddBody(scene, &def, &id);
    }
    qcDetectDef def = qcDefaultDetectDef();
    const qcResult* result = nullptr;
    if (status == qc_statusOk)
        status = qcScene_Detect(scene, &def, &result);
    if (status == qc_statusOk)
        *pairs = result->pairCount;
    qcScene_Destroy(scene);
    return status == qc_statusOk;
}
