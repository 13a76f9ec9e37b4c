#include "record/xdmf.h"

/* One array of one stored shape: entry k of /shapes/name, component c of every `components`. */
static void Slab(FILE *f, const char *h5, const char *name, PetscInt shapes, PetscInt nodes,
                 PetscInt k, int components, int from, int count) {
  if (components == 1)
    fprintf(f,
            "<DataItem ItemType=\"HyperSlab\" Dimensions=\"1 %d\" Type=\"HyperSlab\">"
            "<DataItem Dimensions=\"3 2\" Format=\"XML\">%d 0 1 1 1 %d</DataItem>"
            "<DataItem Dimensions=\"%d %d\" Precision=\"8\" Format=\"HDF\">%s:/shapes/%s"
            "</DataItem></DataItem>",
            (int)nodes, (int)k, (int)nodes, (int)shapes, (int)nodes, h5, name);
  else
    fprintf(f,
            "<DataItem ItemType=\"HyperSlab\" Dimensions=\"1 %d %d\" Type=\"HyperSlab\">"
            "<DataItem Dimensions=\"3 3\" Format=\"XML\">%d 0 %d 1 1 1 1 %d %d</DataItem>"
            "<DataItem Dimensions=\"%d %d %d\" Precision=\"8\" Format=\"HDF\">%s:/shapes/%s"
            "</DataItem></DataItem>",
            (int)nodes, count, (int)k, from, (int)nodes, count, (int)shapes, (int)nodes, components,
            h5, name);
}

static void Scalar(FILE *f, const char *label, const char *h5, const char *name, PetscInt shapes,
                   PetscInt nodes, PetscInt k, int components, int from) {
  fprintf(f, "    <Attribute Name=\"%s\" AttributeType=\"Scalar\" Center=\"Node\">", label);
  Slab(f, h5, name, shapes, nodes, k, components, from, 1);
  fprintf(f, "</Attribute>\n");
}

/* What a rod in space has as vectors: a viewer makes a tube of it, with its directors. */
static void Vectors(FILE *f, const char *h5, PetscInt shapes, PetscInt nodes, PetscInt k,
                    PetscBool contact) {
  static const char *const name[] = {"force", "moment", "strain", "d1", "d2", "d3", "contact"};

  for (int i = 0; i < (contact ? 7 : 6); i++) {
    fprintf(f, "    <Attribute Name=\"%s\" AttributeType=\"Vector\" Center=\"Node\">", name[i]);
    Slab(f, h5, name[i], shapes, nodes, k, 3, 0, 3);
    fprintf(f, "</Attribute>\n");
  }
}

/* The lines of a shape: that of a rod, or those of several, each with its number. */
static void Lines(FILE *f, const char *h5, PetscInt rods, PetscInt nodes) {
  if (rods < 2) {
    fprintf(f,
            "    <Topology TopologyType=\"Polyline\" NumberOfElements=\"1\" "
            "NodesPerElement=\"%d\"/>\n",
            (int)nodes);
    return;
  }
  fprintf(f,
          "    <Topology TopologyType=\"Mixed\" NumberOfElements=\"%d\"><DataItem "
          "Dimensions=\"%d\" NumberType=\"Int\" Precision=\"8\" Format=\"HDF\">%s:/rods/lines"
          "</DataItem></Topology>\n    <Attribute Name=\"rod\" AttributeType=\"Scalar\" "
          "Center=\"Cell\"><DataItem Dimensions=\"%d\" NumberType=\"Int\" Format=\"XML\">",
          (int)rods, (int)(nodes + 2 * rods), h5, (int)rods);
  for (PetscInt k = 0; k < rods; k++) fprintf(f, k ? " %d" : "%d", (int)k);
  fprintf(f, "</DataItem></Attribute>\n");
}

/*
  XdmfWrite - writes FILE.xmf beside a result file FILE.h5: the rod as a polyline that moves in
  time, with its angle, curvature and force, and that of contact if there is any. Not collective. A
  file that cannot be written is passed over, and there is then none: the results are in the other.

  rods   in the file, whose /rods/lines has the nodes of each; 1: all nodes are of one
  nodes  of all
*/
PetscErrorCode XdmfWrite(const char *file, PetscInt rods, PetscInt nodes, PetscInt shapes,
                         const PetscReal t[], PetscBool contact, PetscBool space) {
  char path[PETSC_MAX_PATH_LEN], part[PETSC_MAX_PATH_LEN + 8], *dot;
  const char *slash = strrchr(file, '/'), *h5 = slash ? slash + 1 : file;
  PetscBool whole;
  FILE *f;

  PetscFunctionBegin;
  PetscCall(PetscStrncpy(path, file, sizeof(path) - 4));
  dot = strrchr(path, '.');
  if (dot && !strchr(dot, '/')) *dot = 0;
  PetscCall(PetscStrlcat(path, ".xmf", sizeof(path)));
  (void)snprintf(part, sizeof(part), "%s.part", path);
  f = fopen(part, "w");
  if (!f) PetscFunctionReturn(0);
  fprintf(f, "<?xml version=\"1.0\"?>\n<Xdmf Version=\"2.0\">\n<Domain>\n"
             "<Grid Name=\"rod\" GridType=\"Collection\" CollectionType=\"Temporal\">\n");
  for (PetscInt k = 0; k < shapes; k++) {
    fprintf(f, "  <Grid Name=\"rod\">\n    <Time Value=\"%.15g\"/>\n", (double)t[k]);
    Lines(f, h5, rods, nodes);
    fprintf(f, "    <Geometry GeometryType=\"%s\">", space ? "XYZ" : "XY");
    Slab(f, h5, "x", shapes, nodes, k, space ? 3 : 2, 0, space ? 3 : 2);
    fprintf(f, "</Geometry>\n");
    Scalar(f, "theta", h5, "theta", shapes, nodes, k, 1, 0);
    Scalar(f, "curvature", h5, "curvature", shapes, nodes, k, 1, 0);
    if (space)
      Vectors(f, h5, shapes, nodes, k, contact);
    else {
      Scalar(f, "force_1", h5, "force", shapes, nodes, k, 2, 0);
      Scalar(f, "force_2", h5, "force", shapes, nodes, k, 2, 1);
    }
    if (contact && !space) {
      Scalar(f, "contact_1", h5, "contact", shapes, nodes, k, 2, 0);
      Scalar(f, "contact_2", h5, "contact", shapes, nodes, k, 2, 1);
    }
    fprintf(f, "  </Grid>\n");
  }
  fprintf(f, "</Grid>\n</Domain>\n</Xdmf>\n");
  whole = (PetscBool)!ferror(f);
  whole = (PetscBool)(!fclose(f) && whole);
  if (!whole || rename(part, path)) {
    (void)remove(part);
    (void)remove(path);
  }
  PetscFunctionReturn(0);
}
