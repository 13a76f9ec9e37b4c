#include "world/contact.h"

static const OptionRow rows[] = {
    ROW_TEXT(
        "-wall_file", INPUT_FILE,
        "text file of walls, one a line: plane, circle, polygon or path; in space plane, sphere, "
        "cylinder, cone, torus, tube or body (docs/world.md)"),
    ROW_REAL("-contact_diameter", "0", 0, 1e6, UNIT_LENGTH, 0,
             "D, of the rod: walls meet its surface, and with -contact_self it meets itself"),
    ROW_BOOL("-contact_self", "false", 0, "parts of the rod cannot pass through each other"),
    ROW_BOOL(
        "-contact_rods", "", OF_SCENE,
        "several rods that have a diameter cannot pass through each other (docs/several-rods.md); "
        "if not given it is so if there is a [pair] section"),
    ROW_REAL("-contact_friction", "0", 0, 100, UNIT_NONE, 0,
             "mu_c, friction in contact over its normal force: with walls that do not say their "
             "own, and of the rod with itself"),
    ROW_REAL(
        "-contact_stiffness", "", 1e-6, 1e30, UNIT_NONE, 0,
        "k, force per length and depth, in N/l; if not given it follows from the diameter and the "
        "forces that there are, and without one, or with -accuracy, from the length"),
    ROW_BOOL("-contact_firm", "", 0,
             "k that follows from the diameter grows, up to 16-fold, where the rod is pressed in "
             "by more than 0.075 % of it; where it can touch itself up to 64-fold, from 0.3 % on "
             "(docs/contact.md); if not given it does, unless the run finds no way so")};
const OptionGroup contact_options = OPTION_GROUP_OF_ROD("Contact", rows);

/* ContactMayGetFirm - unless the user says whether it does, contact gets firmer where the rod is
   pressed in, if k follows from its diameter; but no run pays for that before it is. */
PetscErrorCode ContactMayGetFirm(Contact *contact) {
  PetscFunctionBegin;
  if (contact->any && contact->diameter > 0 &&
      !(contact->chosen || contact->given || contact->fine))
    PetscCall(PetscCalloc1(1, &contact->deepest));
  PetscFunctionReturn(0);
}

/* ContactRemedy - what a rod that has nothing to touch is to be given. */
const char *ContactRemedy(void) {
  const CommandLine *line = OptionsLine();

  return line && line->taken.sections > 0
             ? "give -contact_rods, or [pair] with its name, or -wall_file, or -contact_self"
             : "give -wall_file, or -contact_self";
}

/*
  ContactSetFromOptions - reads and checks the options of contact and its walls. Collective; the
  caller ends it with ContactDestroy(), also after an error.

  among     it is one of several rods that may touch each other
  friction  along the rod: that in contact is regularised likewise
*/
PetscErrorCode ContactSetFromOptions(Contact *contact, PetscBool among, const Friction *friction,
                                     PetscReal clamp_angle) {
  char file[PETSC_MAX_PATH_LEN] = "";
  PetscBool walls, rubs, thick;

  PetscFunctionBegin;
  PetscCall(PetscMemzero(contact, sizeof(*contact)));
  PetscCall(OptionText("-wall_file", file, &walls));
  PetscCall(OptionBool("-contact_self", &contact->self, NULL));
  PetscCall(OptionReal("-contact_diameter", &contact->diameter, &thick));
  thick = (PetscBool)(thick && contact->diameter > 0);
  contact->among = (PetscBool)(among && thick);
  PetscCall(OptionReal("-contact_friction", &contact->friction, &rubs));
  PetscCall(OptionReal("-contact_stiffness", &contact->stiffness, &contact->given));
  PetscCall(OptionBool("-contact_firm", &contact->firm, &contact->chosen));
  contact->any = (PetscBool)(walls || ContactOfStrands(contact));
  if (contact->any) PetscCall(OptionReal("-accuracy", &contact->accuracy, &contact->fine));
  UserCheck(contact->any || !(rubs || contact->given || thick), OptionsComm(),
            "%s: there is nothing to touch; %s",
            rubs             ? "-contact_friction"
            : contact->given ? "-contact_stiffness"
                             : "-contact_diameter",
            ContactRemedy());
  UserCheck(!contact->self || contact->diameter > 0, OptionsComm(),
            "-contact_self: give the rod its -contact_diameter");
  UserCheck(!contact->firm || thick, OptionsComm(),
            "-contact_firm: give the rod its -contact_diameter");
  UserCheck(!contact->firm || !(contact->given || contact->fine), OptionsComm(),
            "-contact_firm makes that stiffness grow which follows from the diameter; take %s out",
            contact->given ? "-contact_stiffness" : "-accuracy");
  PetscCall(ContactMayGetFirm(contact));
  contact->rub = FrictionDry(*friction);
  if (walls)
    PetscCall(WallsRead(file, contact->diameter / 2, contact->friction, clamp_angle,
                        &contact->walls, &contact->surfaces));
  UserCheck(
      !rubs || ContactOfStrands(contact) || contact->walls.bare, OptionsComm(),
      "-contact_friction would change nothing: every wall of %s says its own friction; change "
      "it there, or take it out of its line",
      file);
  PetscFunctionReturn(0);
}

/* ContactStaysSoft - it does not, after all. */
PetscErrorCode ContactStaysSoft(Contact *contact) {
  PetscFunctionBegin;
  PetscCall(PetscFree(contact->deepest));
  contact->firm = PETSC_FALSE;
  PetscFunctionReturn(0);
}

/* ContactGetsFirm - does a state whose deepest point, on any rank, is so deep need contact that
   gets firmer, which it was not so far? From now on it does; with the law of up to now what went
   before is what it would have been with this one. */
PetscBool ContactGetsFirm(Contact *contact, PetscReal deepest) {
  if (!contact->deepest || contact->firm || deepest <= contact_firm[0] * contact->smooth)
    return PETSC_FALSE;
  return contact->firm = PETSC_TRUE;
}

/* A force of usual size is not to press the rod in by more than this part of its diameter; of one
   that can touch itself: steps that follow strands feel how stiff these are. */
static const PetscReal part_of_diameter = 2.5e-4, part_of_strands = 1e-3;
/* ... by more than this part of the length of a rod without a diameter; of an accuracy that is
   asked for, by more than that part of it. */
static const PetscReal part_of_length = 9.5e-8, part_of_accuracy = 3.7e-3;
/* The pressure sets in over so many times the depth to which such a force presses: so the step
   feels no kink where a point begins to touch. */
static const PetscReal part_smooth = 2;
/* However soft contact is, nothing is felt farther than this part of the diameter from it. */
static const PetscReal most_smooth = 0.01;

/* Posts less wide than this many cells are met at their feet in part, than so many in full: of the
   others the collocation points are near enough to each other to feel them. */
static const PetscReal cells_of_post[] = {2, 1};

/* ContactNeedsCell - does the law of contact depend on how long the cells are? */
PetscBool ContactNeedsCell(const Contact *contact) {
  return (PetscBool)(contact->any && (contact->walls.posts || contact->surfaces.ridges));
}

/* What contact is not to press in by more than a part of: the diameter; of a rod without one, that
   of the least post. 0: nothing. */
static PetscReal Thickness(const Contact *contact) {
  const PetscReal post = contact->walls.smallest, round = contact->surfaces.smallest;

  if (contact->diameter > 0) return contact->diameter;
  if (contact->surfaces.n == 0 || round == PETSC_MAX_REAL) return 2 * post;
  return 2 * (post > 0 ? PetscMin(post, round) : round);
}

/* How deep a force of usual size is to press the rod in, and the rate of its logarithm. */
static PetscReal AllowedDepth(const Contact *contact, const PetscReal length[2], PetscReal *rate) {
  const PetscReal D = Thickness(contact), L = length[0],
                  part = ContactOfStrands(contact) ? part_of_strands : part_of_diameter,
                  thin = contact->fine ? part_of_accuracy * contact->accuracy : part_of_length,
                  thick = part * PetscMin(D, L);

  if (D > 0 && (!contact->fine || thick < thin * L)) {
    *rate = L < D ? length[1] / L : 0;
    return thick;
  }
  *rate = length[1] / L;
  return thin * L;
}

/*
  ContactSetStiffness - k, unless it is given, and what follows from it. A point load Q on a rod of
  stiffness B sinks in by Q/(2 sqrt(2) k^(3/4) B^(1/4)) and spreads over l = (B/k)^(1/4) (Winkler's
  foundation). Forces are as the scene has them (SceneForce()), or as bending has them in a rod so
  short that these are nothing to it, 10 B/L^2; one that is shorter than thick is to sink in by a
  part of its length.

  B             the largest, or where the rod is stiffest walls would be soft to it; that of the tip
  cell, length  the largest of a cell and of the rod, at present, and their rates
*/
void ContactSetStiffness(Contact *contact, const PetscReal B[2], const PetscReal cell[2],
                         const PetscReal length[2]) {
  const PetscReal of_point = 2 * PETSC_SQRT2, of_tip = PetscPowReal(B[1] / B[0], 0.25),
                  short_rod = 10 * B[0] / (length[0] * length[0]),
                  Q = PetscMax(contact->usual, short_rod), D = Thickness(contact),
                  Q_t = short_rod > contact->usual ? -2 * length[1] / length[0] : 0;
  PetscReal l, l_t, depth, depth_t; /* all rates over what they are of */

  if (!contact->any) return;
  depth = AllowedDepth(contact, length, &depth_t);
  l = PetscPowReal(of_point * depth * B[0] / Q, 1. / 3);
  l_t = (depth_t - Q_t) / 3;
  if (contact->given) {
    l = PetscPowReal(contact->stiffness / B[0], -0.25);
    l_t = 0;
  }
  if (!contact->given) contact->stiffness = B[0] / (l * l * l * l);
  contact->force = Q;
  contact->tip = l * of_tip;
  contact->smooth = part_smooth * Q * l * l * l / (of_point * B[0]);
  contact->smooth_t = (Q_t + 3 * l_t) * contact->smooth;
  if (D > 0 && contact->smooth > most_smooth * D) {
    contact->smooth = most_smooth * D;
    contact->smooth_t = 0;
  }
  contact->stiffness_t = -4 * l_t * contact->stiffness;
  contact->tip_t = l_t * contact->tip;
  contact->cell = cell[0];
  contact->cell_t = cell[1];
  contact->thin =
      (PetscBool)((contact->walls.posts && contact->walls.smallest < cells_of_post[0] * cell[0]) ||
                  (contact->surfaces.ridges && contact->surfaces.smallest + contact->diameter / 2 <
                                                   cells_of_post[0] * cell[0]));
}

/* ContactPostShare - of the strength k l, how much a post of radius rho, with the rod's, is met
   with at its foot: 0 if it is wide, 1 if it is thin; and its rate, for the cells grow. */
PetscReal ContactPostShare(const Contact *contact, PetscReal rho, PetscReal *share_t) {
  const PetscReal width = rho / contact->cell,
                  z = (cells_of_post[0] - width) / (cells_of_post[0] - cells_of_post[1]);

  *share_t = 0;
  if (z <= 0) return 0;
  if (z >= 1) return 1;
  *share_t = 6 * z * (1 - z) * width * contact->cell_t / contact->cell /
             (cells_of_post[0] - cells_of_post[1]);
  return z * z * (3 - 2 * z);
}

/* ContactPostShareSlope - its derivative by rho. */
PetscReal ContactPostShareSlope(const Contact *contact, PetscReal rho) {
  const PetscReal across = cells_of_post[0] - cells_of_post[1],
                  z = (cells_of_post[0] - rho / contact->cell) / across;

  return z <= 0 || z >= 1 ? 0 : -6 * z * (1 - z) / (across * contact->cell);
}

PetscErrorCode ContactDestroy(Contact *contact) {
  PetscFunctionBegin;
  PetscCall(PetscFree(contact->deepest));
  PetscCall(WallsDestroy(&contact->walls));
  PetscCall(SurfacesDestroy(&contact->surfaces));
  PetscFunctionReturn(0);
}

/* ContactWallsText - all walls as a file has them, dimensionless: those of the plane first. The
   caller frees the text (PetscFree). */
PetscErrorCode ContactWallsText(const Contact *contact, char **text) {
  char *flat, *round;
  size_t room;

  PetscFunctionBegin;
  PetscCall(WallsText(&contact->walls, &flat));
  PetscCall(SurfacesText(&contact->surfaces, &round));
  room = strlen(flat) + strlen(round) + 1;
  PetscCall(PetscMalloc1(room, text));
  (void)snprintf(*text, room, "%s%s", flat, round);
  PetscCall(PetscFree(flat));
  PetscCall(PetscFree(round));
  PetscFunctionReturn(0);
}
