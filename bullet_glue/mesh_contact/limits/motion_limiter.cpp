// Meshes never pass each other: objects whose motions are not proven apart over a step are pushed apart, or cut back.
#include "mesh_contact/limits/motion_limiter.h"

#include "common/stopwatch.h"
#include "mesh_contact/limits/limited_velocities.h"
#include "mesh_contact/planes/separating_axis.h"

#include <BulletDynamics/Dynamics/btDynamicsWorld.h>
#include <LinearMath/btQuickprof.h>

#include <algorithm>
#include <iterator>

namespace
{
// A pair nearer than this part of its margins comes no nearer: certificates need a gap above rounding.
// One that would be stopped in the air comes nearer, but not within rounding.
constexpr btScalar s_minGap = btScalar(0.01);
// A stopped pair makes at most this part of what it made before, and nothing once it is below s_minPart.
constexpr btScalar s_maxPart = btScalar(0.99), s_minPart = btScalar(1e-4);
// From these rounds on, objects that are still not proven apart make only the common motion of their island, then none:
// chains of objects that stop each other are shorter.
constexpr int s_maxCuts = 12, s_maxCommon = 24;
// Rounds of planes, and sweeps over all planes in each.
constexpr int s_planeRounds = 6, s_planeSweeps = 8;
// Likewise while pieces of a cut press on each other, from the second round on: pushes have to reach all of a heap.
constexpr int s_closingRounds = 24, s_closingSweeps = 256;
// The search for a separating axis may miss the best one: hulls that touch seem to overlap by less than this part of
// their size, in double by some 1e-7.
constexpr btScalar s_axisError = btScalar(1e-6);
// Sweeps of impulses over the planes of pairs that contact did not stop.
constexpr int s_impulseSweeps = 4;

/// True if convex shapes of one of the two are swept.
bool HasCores(const qcSweptPair& pair)
{
    return pair.first->cores != nullptr || pair.second->cores != nullptr;
}
} // namespace

bool qcMotionLimiter::IsExempt(const qcSweptObject& a, const qcSweptObject& b) const
{
    return m_islands.MoveAsOne(a, b) || m_exempt.count(std::minmax(a.number, b.number)) > 0;
}

/// True if two convex meshes that have not met in this step are in each other at its start by more than rounding. Where
/// their sides are flush, their triangles don't show it.
bool qcMotionLimiter::AreInEachOther(const qcSweptObject& a, const qcSweptObject& b, const qcProximity& atStart) const
{
    if (!qcHaveHulls(a, b, m_inner) || m_meeting.count(std::minmax(a.number, b.number)) > 0 || !a.hull->IsConvex() ||
        !b.hull->IsConvex())
        return false;
    qcPlacedSupport startA{a.hull, a.start}, startB{b.hull, b.start};
    btScalar gap = qcFindSeparation(startA, startB, qcVectorOf(atStart.normal), BT_LARGE_FLOAT, 0).gap;
    return gap < -4 * qcTouchingDepth(a, b) - qcGapError(startA, startB) -
                     s_axisError * (a.hull->Radius() + b.hull->Radius());
}

/// How two triangles meet at the start of the step.
qcMotionLimiter::Meeting qcMotionLimiter::FindMeeting(const qcPair& pair, const qcSweptTriangles& triangles) const
{
    const qcSweptObject &a = *triangles.a.swept, &b = *triangles.b.swept;
    if (pair.relation == qc_relationDisjoint && triangles.atStart->distance > double(qcCertifiableGap(a, b)))
        return Meeting::none;
    return triangles.ArePenetrating(2 * qcTouchingDepth(a, b)) || AreInEachOther(a, b, *triangles.atStart)
               ? Meeting::penetrates
               : Meeting::touches;
}

/// True if a pair is tested by cores that inner ones can take the place of.
bool qcMotionLimiter::IsTestedByCores(const qcSweptPair& pair) const
{
    const Numbers numbers = qcNumbersOf(pair);
    return HasCores(pair) && m_inner.count(numbers) == 0 && m_exempt.count(numbers) == 0;
}

void qcMotionLimiter::UseInnerCores(const qcSweptPair& pair)
{
    m_inner.insert(qcNumbersOf(pair));
    m_objects.AddInnerCores(pair.first);
    m_objects.AddInnerCores(pair.second);
}

/// Pairs whose cores are in the other object at the start are tested by inner cores. True: there are new ones, so that
/// the result is void. Those whose mesh is inside of the inner core are exempt: Bullet's contact pushes it out.
bool qcMotionLimiter::ExchangeCores(const qcResult& result)
{
    const size_t before = m_inner.size();
    for (size_t i = 0; i < result.pairCount; i++)
    {
        const qcSweptTriangles triangles = m_scene.TrianglesOf(result.pairs[i], result.proximities[i]);
        const qcSweptPair objects = triangles.Objects();
        if (IsTestedByCores(objects) && FindMeeting(result.pairs[i], triangles) == Meeting::penetrates)
            UseInnerCores(objects);
    }
    auto isInside = [](const qcSweptPair& pair, qcSweptPart core)
    { return pair.first->EnclosesAtStart(core, *pair.second) || pair.second->EnclosesAtStart(core, *pair.first); };
    for (const qcSweptPair& pair : m_pairs)
        if (IsTestedByCores(pair) && isInside(pair, qcSweptPart::core))
            UseInnerCores(pair);
        else if (m_inner.count(qcNumbersOf(pair)) > 0 && isInside(pair, qcSweptPart::innerCore))
            m_exempt.insert(qcNumbersOf(pair));
    return m_inner.size() > before;
}

/// Objects that meet at the start only touch, up to rounding, or are exempt as a whole: a triangle inside another
/// object has to leave it. True: pairs of small meshes touch that did not count as such.
bool qcMotionLimiter::CollectMeetings(const qcResult& result)
{
    bool anyNew = false;
    for (size_t i = 0; i < result.pairCount; i++)
    {
        const qcSweptTriangles triangles = m_scene.TrianglesOf(result.pairs[i], result.proximities[i]);
        const Meeting meeting = FindMeeting(result.pairs[i], triangles);
        if (meeting == Meeting::none)
            continue;
        const bool touches = meeting == Meeting::touches;
        const Numbers numbers = qcNumbersOf(triangles.Objects());
        (touches ? m_meeting : m_exempt).insert(numbers);
        if (touches && qcHaveHulls(*triangles.a.swept, *triangles.b.swept, m_inner))
            anyNew = m_touching.Add(numbers) || anyNew;
    }
    return anyNew;
}

/// Finds the pairs of triangles that are not exempt and end neither proven apart nor as they have met at the start.
void qcMotionLimiter::FindUnproven(const qcResult& result, bool pushes)
{
    m_unprovenTriangles.clear();
    for (size_t i = 0; i < result.pairCount; i++)
    {
        qcSweptTriangles triangles = m_scene.TrianglesOf(result.pairs[i], result.proximities[i]);
        const qcSweptObject &a = *triangles.a.swept, &b = *triangles.b.swept;
        if (IsExempt(a, b))
            continue;
        if (m_meeting.count(qcNumbersOf(triangles.Objects())) > 0)
            triangles.MeetWithin(qcTouchingDepth(a, b));
        if (triangles.IsUnproven(pushes))
            m_unprovenTriangles.push_back(triangles);
    }
}

/// The parts of their own motion that the free bodies of a pair make, the larger one of two; 0: there are none.
qcMotionLimiter::MadeParts qcMotionLimiter::FindMadeParts(const qcSweptPair& pair)
{
    MadeParts made;
    for (const qcSweptObject* swept : {pair.first, pair.second})
        if (swept->CanBeCut())
        {
            btScalar& part = swept->body != nullptr ? made.ofBodies : made.ofLinks;
            part = std::max(part, swept->MadePart());
        }
    return made;
}

/// Cuts the motions of a pair, relative to their island's, back to a part.
void qcMotionLimiter::Stop(const qcSweptPair& pair, btScalar part, btScalar distance)
{
    const MadeParts parts = FindMadeParts(pair);
    btScalar made = parts.ThatIsCut(), travel = 0;
    for (const qcSweptObject* swept : {pair.first, pair.second})
        travel += qcDisplacementBound(swept->carried, swept->target, swept->radius);
    // The pair keeps a distance, but approaches by at least half of what is proven. The part is less than what is made,
    // also where the scene's rounding differs.
    part =
        std::min(std::max(part / 2, part - distance / travel), made / 2 < s_minPart ? btScalar(0) : made * s_maxPart);
    for (qcSweptObject* swept : {pair.first, pair.second})
        if (swept->body != nullptr)
            swept->fraction = std::min(swept->fraction, part);
        else if (swept->CanBeCut() && !parts.CutsBodies())
            swept->multibody->CutTo(part);
}

/// True if the common motion of the pair's island is none, so that its objects would be stopped in the air.
bool qcMotionLimiter::IsStill(const qcSweptPair& pair) const
{
    const qcSweptObject& free = pair.first->body != nullptr ? *pair.first : *pair.second;
    if (free.body == nullptr)
        return false;
    const qcSweptObject* carrier = m_islands.CarrierOf(free);
    return !m_islands.IsFree(free) && (carrier == nullptr || !carrier->moves);
}

/// Holds the islands of a pair, or where these are held its multibodies. False: those are held, too.
bool qcMotionLimiter::Hold(const qcSweptPair& pair)
{
    bool changes = false;
    for (const qcSweptObject* swept : {pair.first, pair.second})
        changes = (swept->body != nullptr && m_islands.Hold(*swept)) || changes;
    const bool holdsLinks = !changes;
    for (const qcSweptObject* swept : {pair.first, pair.second})
        changes = (holdsLinks && swept->multibody != nullptr && swept->multibody->CutTo(0)) || changes;
    return changes;
}

/// The common motion does not keep a pair apart, by rounding or since carriers have different motions: its islands stay
/// at their starts. If they do already, the pair can't be kept apart in this step.
void qcMotionLimiter::Release(const qcSweptPair& pair)
{
    bool changes = Hold(pair);
    for (qcSweptObject* swept : {pair.first, pair.second})
    {
        if (!swept->IsFree())
            continue;
        // The last detection has not seen an island at its start that was held since.
        changes = changes || !qcAreSame(swept->end, swept->tested);
        if (swept->body == nullptr)
            continue;
        changes = changes || swept->fraction > 0 || !qcAreSame(swept->end, swept->start);
        swept->fraction = 0;
    }
    if (changes)
        return;
    m_exempt.insert(qcNumbersOf(pair));
    m_unproven++;
}

/// The pairs that touch at the start and end too deep.
std::vector<qcClosingPair> qcMotionLimiter::ClosingPairs() const
{
    std::vector<qcClosingPair> closing = m_touching.Closing();
    auto isExempt = [this](const qcClosingPair& touching)
    { return IsExempt(*touching.pair.first, *touching.pair.second); };
    closing.erase(std::remove_if(closing.begin(), closing.end(), isExempt), closing.end());
    return closing;
}

/// Adds planes for the pairs of triangles that are not proven apart. Where faces of two objects lie on each other,
/// planes between these part their other triangles, too, whose directions are less certain.
void qcMotionLimiter::AddPlanes()
{
    std::set<Numbers> facing;
    for (const qcSweptTriangles& triangles : m_unprovenTriangles)
        if (triangles.FaceEachOther())
            facing.insert(qcNumbersOf(triangles.Objects()));
    for (const qcSweptTriangles& triangles : m_unprovenTriangles)
    {
        const Numbers numbers = qcNumbersOf(triangles.Objects());
        if (triangles.meet && !triangles.FaceEachOther() && facing.count(numbers) > 0)
            continue;
        triangles.AddPlane(&m_planes);
        m_stopped.insert(numbers);
    }
}

/// From now on motions are those to the ends that the planes have found.
void qcMotionLimiter::EndPlanes()
{
    for (qcSweptObject* swept : m_objects.Get())
        swept->target = swept->end;
}

/// Unites the islands of objects that are not proven apart.
void qcMotionLimiter::JoinBlocked()
{
    auto join = [this](const qcSweptObject& a, const qcSweptObject& b)
    {
        if (a.body != nullptr || b.body != nullptr)
            m_islands.Join(a, b);
    };
    for (const qcSweptTriangles& triangles : m_unprovenTriangles)
        if (!IsExempt(*triangles.a.swept, *triangles.b.swept))
            join(*triangles.a.swept, *triangles.b.swept);
    for (const qcClosingPair& closing : ClosingPairs())
        join(*closing.pair.first, *closing.pair.second);
}

/// The first pair of triangles that meets, or their hulls, for each two objects that are not proven apart.
std::map<qcMotionLimiter::Numbers, qcMotionLimiter::Block> qcMotionLimiter::FindBlocks() const
{
    std::map<Numbers, Block> blocks;
    for (const qcSweptTriangles& triangles : m_unprovenTriangles)
    {
        qcSweptPair objects(triangles.a.swept, triangles.b.swept);
        if (IsExempt(*objects.first, *objects.second))
            continue;
        Block& block = blocks[qcNumbersOf(objects)];
        btScalar part = triangles.FindPart(block.part);
        if (block.pair.first == nullptr || part < block.part)
            block = {objects, part, btScalar(triangles.atStart->distance), 0};
    }
    for (const qcClosingPair& closing : ClosingPairs())
        blocks[qcNumbersOf(closing.pair)] = {closing.pair, closing.FindPart(1), 0, 0};
    for (auto& [numbers, block] : blocks)
        block.made = FindMadeParts(block.pair).ThatIsCut();
    return blocks;
}

/// Cuts the motions of objects that are not proven apart back to the common motion of their island and a part of what
/// differs from it.
void qcMotionLimiter::Cut(int round)
{
    JoinBlocked();
    m_islands.Move();
    for (const auto& [numbers, block] : FindBlocks())
    {
        btScalar margins = block.pair.first->Margin() + block.pair.second->Margin();
        btScalar minGap =
            IsStill(block.pair) ? qcCornerRounding(*block.pair.first, *block.pair.second) : s_minGap * margins;
        bool common = round >= s_maxCuts || block.distance < minGap;
        btScalar part = common ? std::min(block.part, btScalar(0)) : block.part;
        if (part < 0 || block.made <= 0)
            Release(block.pair);
        else
            Stop(block.pair, part, qcMotionFloor * margins);
        if (part >= 0 && round >= s_maxCommon)
            Hold(block.pair);
        m_cut.insert(numbers);
    }
    m_objects.MultiBodies().ForAll(&qcSweptMultiBody::Move);
    m_islands.Move();
}

/// Moves the bodies. Pairs that were stopped in the previous step, too, lose the velocities that stop them, or bounce:
/// contact has not done it. Nor does it where the application sweeps an object over a body: Bullet finds contact at the
/// end of the sweep.
void qcMotionLimiter::CommitAll(btScalar timeStep)
{
    for (qcSweptObject* swept : m_objects.Get())
    {
        if (swept->body != nullptr && (swept->pushes > 0 || swept->fraction < 1))
            qcMoveLimited(swept, m_islands.CarrierOf(*swept), timeStep);
        else if (swept->multibody != nullptr && (swept->pushes > 0 || swept->MadePart() < 1))
            swept->isLimited = true;
    }
    auto isStoppedAgain = [this](const qcSweptObject& a, const qcSweptObject& b)
    {
        const Numbers numbers = std::minmax(a.number, b.number);
        return a.IsSwept() || b.IsSwept() || m_previouslyStopped.count(numbers) > 0 ||
               ((a.multibody != nullptr || b.multibody != nullptr) && m_previouslyCut.count(numbers) > 0);
    };
    auto* world = dynamic_cast<btDynamicsWorld*>(m_settings.world);
    const btScalar slowest = world != nullptr ? world->getSolverInfo().m_restitutionVelocityThreshold : BT_LARGE_FLOAT;
    m_planes.RemoveApproaches(s_impulseSweeps, slowest, isStoppedAgain);
    m_objects.MultiBodies().UpdateVelocities();
    std::set<uint32_t> cutAgain;
    for (const Numbers& numbers : m_cut)
        if (m_previouslyCut.count(numbers) > 0)
            cutAgain.insert({numbers.first, numbers.second});
    m_islands.Damp(cutAgain);
}

/// Finds the pairs of a round: of those that the previous round has not moved, the ones that it has not proven apart.
void qcMotionLimiter::FindPairs(bool isFirst)
{
    for (qcSweptObject* swept : m_objects.Get())
        swept->isUnmoved = !isFirst && qcAreSame(swept->end, swept->certified);
    m_objects.FindPairs(m_scene.Get(), &m_pairs);
    if (!isFirst)
        std::copy_if(m_unprovenPairs.begin(), m_unprovenPairs.end(), std::back_inserter(m_pairs),
                     [](const qcSweptPair& pair) { return pair.first->isUnmoved && pair.second->isUnmoved; });
}

/// Wakes the bodies near meshes that deform: Bullet does so next to kinematic bodies only.
void qcMotionLimiter::WakeNearDeforming() const
{
    // Once for each object: large compounds have thousands of meshes, and many pairs.
    const std::vector<qcSweptObject*>& objects = m_objects.Get();
    if (std::none_of(objects.begin(), objects.end(), [](const qcSweptObject* swept) { return swept->Deforms(); }))
        return;
    for (const qcSweptPair& pair : m_pairs)
        for (const auto& [swept, other] : {pair, qcSweptPair(pair.second, pair.first)})
            if (swept->body != nullptr && other->Deforms())
                swept->body->activate();
}

void qcMotionLimiter::SortPairs()
{
    std::sort(m_pairs.begin(), m_pairs.end(), qcIsBefore);
}

/// Leaves out the pairs that are exempt, and those that the last detection did not report and that have not moved
/// since.
void qcMotionLimiter::SkipSettledPairs(const std::set<Numbers>& reported)
{
    auto isSettled = [&](const qcSweptPair& pair)
    {
        Numbers numbers = qcNumbersOf(pair);
        bool isTested =
            qcAreSame(pair.first->end, pair.first->tested) && qcAreSame(pair.second->end, pair.second->tested);
        return (isTested && reported.count(numbers) == 0) || m_exempt.count(numbers) > 0;
    };
    m_pairs.erase(std::remove_if(m_pairs.begin(), m_pairs.end(), isSettled), m_pairs.end());
}

/// True if one of the triangles that are not proven apart belongs to an object that planes can push.
bool qcMotionLimiter::CanPush() const
{
    return std::any_of(m_unprovenTriangles.begin(), m_unprovenTriangles.end(),
                       [](const qcSweptTriangles& triangles)
                       {
                           const qcSweptObject &a = *triangles.a.swept, &b = *triangles.b.swept;
                           return a.CanBePushedBy(b) || b.CanBePushedBy(a);
                       });
}

/// True if the application moves an object of one of the pairs of triangles of the previous round that were not proven
/// apart: no cut of motions parts them.
bool qcMotionLimiter::AreDriven() const
{
    return std::any_of(m_unprovenTriangles.begin(), m_unprovenTriangles.end(),
                       [](const qcSweptTriangles& triangles)
                       { return triangles.a.swept->IsSwept() || triangles.b.swept->IsSwept(); });
}

/// Detects the pairs that are not proven apart, and adds planes for them where `pushes`. Otherwise, after `cuts` such
/// rounds, or where planes can push none, it cuts them.
qcMotionLimiter::Round qcMotionLimiter::StopPairs(bool pushes, int cuts, std::set<Numbers>* reported)
{
    if (m_pairs.empty() && !m_touching.AnyTouches())
        return Round::ended;
    const qcResult none{};
    const qcResult* result = &none;
    if (!m_pairs.empty())
        m_status = m_scene.Detect(m_pairs, m_inner, &result);
    if (m_status != qc_statusOk)
        return Round::ended;
    for (qcSweptObject* swept : m_objects.Get())
        swept->tested = swept->end;
    reported->clear();
    for (size_t i = 0; i < result->pairCount; i++)
        reported->insert(m_scene.NumbersOf(result->pairs[i]));
    for (const qcClosingPair& closing : m_touching.Closing())
        reported->insert(qcNumbersOf(closing.pair));
    if (ExchangeCores(*result))
        return Round::exchanged;
    const bool anyNew = CollectMeetings(*result);
    if (pushes && anyNew)
        return Round::pushed;
    FindUnproven(*result, pushes);
    if (m_unprovenTriangles.empty() && (pushes || ClosingPairs().empty()))
        return pushes && m_touching.AnyTouches() ? Round::pushed : Round::ended;
    if (pushes && (CanPush() || m_touching.AnyTouches()))
    {
        AddPlanes();
        return Round::pushed;
    }
    if (cuts == 0)
        EndPlanes();
    Cut(cuts);
    return Round::cut;
}

/// Rounds of certificates and planes, then cuts, until all pairs are proven apart or exempt.
qcStatus qcMotionLimiter::Certify()
{
    std::set<Numbers> reported;
    m_status = qc_statusOk;
    int cuts = 0;
    Round done = Round::pushed;
    for (int round = 0; done != Round::ended; round++)
    {
        FindPairs(round == 0);
        if (round == 0)
            WakeNearDeforming();
        else
            SkipSettledPairs(reported);
        m_certificates.RemoveApart(m_inner, &m_pairs);
        SortPairs();
        m_unprovenPairs = m_pairs;
        for (qcSweptObject* swept : m_objects.Get())
            swept->certified = swept->end;
        m_certificates.RemoveSeparated(m_inner, &m_touching, &m_planes, &m_pairs);
        const bool isClosing = !ClosingPairs().empty();
        const int rounds = isClosing || (round > 0 && AreDriven()) ? s_closingRounds : s_planeRounds;
        done = StopPairs(cuts == 0 && round < rounds, cuts, &reported);
        if (done == Round::pushed)
        {
            // Multibodies turn little at a time.
            const int sweeps = round > 0 && isClosing ? s_closingSweeps : s_planeSweeps;
            for (int sweep = 0; sweep < sweeps; sweep++)
            {
                m_planes.SolveOnce();
                m_objects.MultiBodies().ForAll(&qcSweptMultiBody::CommitPushes);
            }
        }
        cuts += done == Round::cut;
    }
    return m_status;
}

void qcMotionLimiter::WriteStatistics(double start, qcMeshContactStatistics* statistics)
{
    statistics->limited = 0;
    for (const qcSweptObject* swept : m_objects.Get())
        statistics->limited += swept->isLimited;
    statistics->unproven = m_unproven;
    statistics->limitMs += qcNowMs() - start;
}

void qcMotionLimiter::Run(btScalar timeStep, qcMeshContactStatistics* statistics)
{
    BT_PROFILE("qcMeshContact limit");
    m_planes.Clear();
    // Those of the last step may be of objects that are gone.
    m_unprovenTriangles.clear();
    m_islands.Reset(m_objects.Get());
    qcStatus status = Certify();
    if (status != qc_statusOk)
        statistics->status = status;
    CommitAll(timeStep);
}

void qcMotionLimiter::Limit(btScalar timeStep, qcMeshContactStatistics* statistics)
{
    double start = qcNowMs();
    m_previouslyStopped.swap(m_stopped);
    m_previouslyCut.swap(m_cut);
    m_stopped.clear();
    m_cut.clear();
    m_exempt.clear();
    m_meeting.clear();
    m_inner.clear();
    m_unproven = 0;
    m_touching.BeginStep();
    statistics->limitMs = 0;
    if (m_objects.ReadMotions(timeStep, m_scene.Get()))
        Run(timeStep, statistics);
    // What Run has pushed may be near convex shapes that had no reason to take part.
    if (m_objects.MissesCores())
    {
        m_objects.ReadTargets([](const btCollisionObject*) { return nullptr; }, m_scene.Get());
        Run(timeStep, statistics);
    }
    m_objects.RecordEnds();
    WriteStatistics(start, statistics);
}

void qcMotionLimiter::LimitAgain(btScalar timeStep, const std::vector<const btCollisionObject*>& held,
                                 const qcStartFunction& startOf, std::vector<const btCollisionObject*>* moved,
                                 qcMeshContactStatistics* statistics)
{
    m_objects.MultiBodies().ForgetGone();
    if (held.empty() && m_objects.AreAtEnds())
        return;
    double start = qcNowMs();
    for (const btCollisionObject* object : held)
    {
        qcSweptObject* swept = m_objects.Find(object);
        if (swept == nullptr || swept->body == nullptr)
            m_objects.MultiBodies().ReturnToStart(object, moved);
        else if (!qcAreSame(swept->body->getWorldTransform(), swept->start))
        {
            swept->body->proceedToTransform(swept->start);
            swept->isLimited = true;
            moved->push_back(object);
        }
    }
    m_objects.ReadTargets(startOf, m_scene.Get());
    for (const btCollisionObject* object : held)
        m_objects.Hold(object);
    Run(timeStep, statistics);
    for (const qcSweptObject* swept : m_objects.Get())
        if (swept->body != nullptr && (swept->pushes > 0 || swept->fraction < 1))
            moved->push_back(swept->object);
    m_objects.MultiBodies().ForEachLimitedLink([moved](const btCollisionObject* link) { moved->push_back(link); });
    m_objects.RecordEnds();
    WriteStatistics(start, statistics);
}
